// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/aside.hpp"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>
#include <utility>

#include "control/codec.hpp"
#include "control/slices.hpp"
#include "daemon/clock.hpp"

namespace mlcca {
namespace {

constexpr std::size_t kRowsOfSlice = 64;
constexpr std::size_t kReadSize = 64UL * 1024;
constexpr int kMostFiles = 65'536;

serve::Slice failure(std::string text) {
  return {control::Error{control::ErrorKind::world, std::move(text), {}}};
}

// --- in the child --------------------------------------------------------------------------------

/// Clients, the kernel and the next daemon must not take the child for this one: it has none of the
/// sockets, nor the files and folders that are locked by whoever has them open.
void close_what_is_shared(int keep) {
  const auto limit = std::min<rlim_t>(kMostFiles, [] {
    rlimit files{};
    return ::getrlimit(RLIMIT_NOFILE, &files) == 0 ? files.rlim_cur : rlim_t{kMostFiles};
  }());
  for (int fd = 3; fd < static_cast<int>(limit); ++fd) {
    struct stat is{};
    if (fd == keep || ::fstat(fd, &is) != 0) continue;
    if (S_ISSOCK(is.st_mode) || S_ISREG(is.st_mode) || S_ISDIR(is.st_mode)) ::close(fd);
  }
}

void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) ::_exit(1);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

/// Less urgent than the daemon, ends with it, and is the first to go where memory is short.
[[noreturn]] void be_child(int out, pid_t parent, const Aside::Make& make) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  ::setpriority(PRIO_PROCESS, 0, 10);
  const rlimit seconds{Aside::kLongest / 1'000'000'000, Aside::kLongest / 1'000'000'000};
  ::setrlimit(RLIMIT_CPU, &seconds);
  const Fd victim(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  if (victim && ::write(victim.get(), "1000", 4) < 0) {
    // It is only a wish.
  }
  close_what_is_shared(out);
  for (const control::Reply& slice : control::split({0, make()}, kRowsOfSlice))
    write_all(out, control::encode(slice));
  ::_exit(0);
}

}  // namespace

// --- one report ----------------------------------------------------------------------------------

/// Waits for a free place, runs, and is read; its end ends the child.
class Aside::Report {
 public:
  Report(Aside& aside, const serve::Peer& peer, Make make)
      : aside_(aside), peer_(peer), make_(std::move(make)) {
    aside_.reports_.push_back(this);
  }
  Report(const Report&) = delete;
  Report& operator=(const Report&) = delete;
  Report(Report&&) = delete;
  Report& operator=(Report&&) = delete;
  ~Report() { end(); }

  [[nodiscard]] uid_t uid() const { return peer_.uid; }
  [[nodiscard]] bool runs() const { return child_ > 0; }
  /// Why it is to end, if it is.
  [[nodiscard]] const char* overdue(std::uint64_t now) const {
    if (!runs()) return nullptr;
    if (now - begun_ > kLongest) return "it takes more than 60 s";
    if (now > unread_since_ && now - unread_since_ > kUnread) return "it is not read";
    return nullptr;
  }

  void start() {
    std::array<int, 2> ends{-1, -1};
    if (::pipe2(ends.data(), O_CLOEXEC) < 0) {
      fail(std::string("pipe: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
      return;
    }
    in_ = Fd(ends[0]);
    const Fd out(ends[1]);
    ::fcntl(in_.get(), F_SETFL, O_NONBLOCK);  // NOLINT(*-vararg)
    const pid_t parent = ::getpid();
    begun_ = monotonic_ns();
    child_ = ::fork();
    if (child_ == 0) be_child(out.get(), parent, make_);
    make_ = nullptr;
    if (child_ < 0) {
      fail(std::string("fork: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
      return;
    }
    sd_event_source* raw = nullptr;
    if (sd_event_add_io(aside_.loop_, &raw, in_.get(), EPOLLIN, on_data, this) < 0) {
      fail("the loop does not take it");
      return;
    }
    source_.reset(raw);
    sd_event_source_set_enabled(raw, SD_EVENT_ONESHOT);
  }

  /// What there is instead of a reply.
  void fail(const std::string& why) {
    failed_ = "the report cannot be made: " + why;
    end();
    aside_.ready_(peer_.session);
  }

  std::optional<serve::Slice> next() {
    for (;;) {
      if (!failed_.empty()) return failure(failed_);
      if (!runs()) return std::nullopt;
      auto reply = control::decode_reply(buffer_);
      if (!reply) return give_up(reply.error().text);
      if (*reply) {
        serve::Slice slice{std::move((*reply)->body), (*reply)->more};
        unread_since_ = monotonic_ns();
        if (!slice.more) end();
        return slice;
      }
      const auto room = buffer_.space(kReadSize);
      const ssize_t n = ::read(in_.get(), room.data(), room.size());
      if (n > 0) buffer_.commit(static_cast<std::size_t>(n));
      if (n == 0) return give_up("the process that makes it has ended");
      if (n < 0 && errno != EINTR) {
        sd_event_source_set_enabled(source_.get(), SD_EVENT_ONESHOT);
        unread_since_ = ~0ULL;
        return std::nullopt;
      }
    }
  }

 private:
  static int on_data(sd_event_source*, int, std::uint32_t, void* self) noexcept {
    auto& report = *static_cast<Report*>(self);
    report.unread_since_ = monotonic_ns();
    report.aside_.ready_(report.peer_.session);
    return 0;
  }

  serve::Slice give_up(const std::string& why) {
    end();
    return failure("the report cannot be made: " + why);
  }

  /// Makes room for another one.
  void end() {
    std::erase(aside_.reports_, this);
    source_.reset();
    in_ = Fd();
    const pid_t child = std::exchange(child_, 0);
    if (child > 0) aside_.ended(child);
  }

  Aside& aside_;
  serve::Peer peer_;
  Make make_;
  pid_t child_ = 0;
  std::uint64_t begun_ = 0;
  std::uint64_t unread_since_ = ~0ULL;  ///< it waits for the client; otherwise the client for it
  Fd in_;
  std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>> source_;
  control::Buffer buffer_;
  std::string failed_;
};

// --- all of them ---------------------------------------------------------------------------------

Aside::~Aside() { reap(); }

serve::NextSlice Aside::ask(const serve::Peer& peer, Make make) {
  auto report = std::make_shared<Report>(*this, peer, std::move(make));
  start_waiting();
  return [report = std::move(report)] { return report->next(); };
}

/// Of those who wait the one whose user has waited longest for anything.
void Aside::start_waiting() {
  const auto running = [this](auto&& matches) {
    return std::ranges::count_if(reports_,
                                 [&](const Report* r) { return r->runs() && matches(r); });
  };
  for (;;) {
    if (running([](const Report*) { return true; }) >= static_cast<std::ptrdiff_t>(kAtOnce)) return;
    Report* next = nullptr;
    std::uint64_t oldest = ~0ULL;
    for (Report* r : reports_) {
      if (r->runs() || running([&](const Report* o) { return o->uid() == r->uid(); }) != 0)
        continue;
      const auto known = last_started_.find(r->uid());
      const std::uint64_t started = known == last_started_.end() ? 0 : known->second;
      if (started >= oldest) continue;
      oldest = started;
      next = r;
    }
    if (next == nullptr) return;
    last_started_[next->uid()] = monotonic_ns();
    next->start();
  }
}

void Aside::ended(pid_t child) {
  ::kill(child, SIGKILL);
  ended_.push_back(child);
  reap();
  start_waiting();
}

/// One that has not ended yet gives its memory back first.
void Aside::reap() {
  std::erase_if(ended_, [](pid_t child) { return ::waitpid(child, nullptr, WNOHANG) != 0; });
}

void Aside::look() {
  reap();
  const std::uint64_t now = monotonic_ns();
  std::erase_if(last_started_, [now](const auto& u) { return now - u.second > kLongest; });
  for (Report* report : std::vector(reports_))
    if (const char* why = report->overdue(now)) report->fail(why);
}

}  // namespace mlcca
