// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/aside.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/number.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"

namespace mlcca {
namespace {

constexpr std::size_t kRowsOfSlice = 64;
constexpr int kMostFiles = 65'536;
/// Precedes each slice in the memory file that the child leaves.
struct Head {
  std::uint32_t bytes = 0;
  std::uint32_t more = 0;
};
constexpr const char* kTooLarge = "the report cannot be made: it has more than 64 MiB";
static_assert(Aside::kMostBytes == std::size_t{64} << 20);

serve::Slice failure(std::string text) {
  return {control::Error{control::ErrorKind::world, std::move(text), {}}};
}

// --- in the child --------------------------------------------------------------------------------

/// The open descriptors of this process, as the kernel lists them; all possible ones if it cannot
/// be asked.
std::vector<int> open_descriptors() {
  std::vector<int> found;
  const std::unique_ptr<DIR, FreeWith<::closedir>> listed(::opendir("/proc/self/fd"));
  bool complete = false;
  while (listed && !complete) {
    errno = 0;
    const dirent* const entry = ::readdir(listed.get());  // NOLINT(concurrency-mt-unsafe)
    if (entry == nullptr && errno != 0) break;
    complete = entry == nullptr;
    if (const auto fd = entry != nullptr ? number_in<int>(entry->d_name) : std::nullopt)
      found.push_back(*fd);
  }
  if (complete) return found;
  rlimit files{};
  const bool known = ::getrlimit(RLIMIT_NOFILE, &files) == 0;
  found.resize(std::min<rlim_t>(kMostFiles, known ? files.rlim_cur : rlim_t{kMostFiles}));
  std::iota(found.begin(), found.end(), 0);
  return found;
}

/// Closes what the child must not share with the daemon, so that clients, the kernel and the next
/// daemon do not take the child for it: sockets, and files and folders, which may be locked. A
/// descriptor that cannot be inspected is closed as well.
void close_what_is_shared(int keep) {
  for (const int fd : open_descriptors()) {
    struct stat is{};
    if (fd < 3 || fd == keep) continue;
    if (::fstat(fd, &is) != 0 || S_ISSOCK(is.st_mode) || S_ISREG(is.st_mode) || S_ISDIR(is.st_mode))
      ::close(fd);
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

void write_slice(int memory, std::string_view encoded, bool more) {
  const Head head{static_cast<std::uint32_t>(encoded.size()), more ? 1U : 0U};
  std::array<char, sizeof head> bytes{};
  std::memcpy(bytes.data(), &head, sizeof head);
  write_all(memory, {bytes.data(), bytes.size()});
  write_all(memory, encoded);
}

void write_report(int memory, control::Reply whole, bool may_slice) {
  if (!may_slice) {
    write_slice(memory, control::encode_body(whole, control::Reply::kMaxBytesUnsliced), false);
    return;
  }
  std::size_t written = 0;
  for (const control::Reply& slice : control::slices_of(std::move(whole), kRowsOfSlice)) {
    const std::string encoded = control::encode_body(slice, Aside::kMostOfSlice);
    written += encoded.size();
    if (written > Aside::kMostBytes) {
      if (::ftruncate(memory, 0) < 0 || ::lseek(memory, 0, SEEK_SET) < 0) ::_exit(1);
      write_slice(memory, control::encode_body({0, failure(kTooLarge).body}), false);
      return;
    }
    write_slice(memory, encoded, slice.more);
  }
}

/// The child: it is less urgent than the daemon, ends when the daemon ends, and is the first to be
/// killed when memory is short.
[[noreturn]] void be_child(int memory, pid_t parent, const Aside::Make& make, bool may_slice) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  std::set_new_handler(+[] { ::_exit(1); });  // the daemon's handler would say that the daemon ends
  ::setpriority(PRIO_PROCESS, 0, 10);
  const rlimit seconds{Aside::kLongest / 1'000'000'000, Aside::kLongest / 1'000'000'000};
  ::setrlimit(RLIMIT_CPU, &seconds);
  const Fd victim(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  if (victim && ::write(victim.get(), "1000", 4) < 0) {
    // It is only a preference.
  }
  close_what_is_shared(memory);
  write_report(memory, {0, make()}, may_slice);
  ::_exit(0);
}

}  // namespace

// --- one report ----------------------------------------------------------------------------------

/// One report: it waits for a free place, runs in a child, and is kept until it has been read.
/// While it is read it has no child, so a slow client does not occupy a place.
class Aside::Report {
 public:
  Report(Aside& aside, serve::Peer peer, Make make, bool may_slice)
      : aside_(aside), peer_(std::move(peer)), make_(std::move(make)), may_slice_(may_slice) {
    aside_.reports_.push_back(this);
  }
  Report(const Report&) = delete;
  Report& operator=(const Report&) = delete;
  Report(Report&&) = delete;
  Report& operator=(Report&&) = delete;
  ~Report() { end(); }

  [[nodiscard]] const serve::Peer& peer() const { return peer_; }
  [[nodiscard]] uid_t uid() const { return peer_.uid; }
  [[nodiscard]] serve::Turns::User user() const { return {peer_.uid, peer_.may_change}; }
  [[nodiscard]] bool waits() const { return child_ == 0 && !made_ && !forsaken_; }
  [[nodiscard]] bool runs() const { return child_ > 0; }
  /// Bytes that are made and not read yet; and when it was made, ns.
  [[nodiscard]] std::size_t kept() const { return made_ ? size_ - read_ : 0; }
  [[nodiscard]] std::uint64_t made_at() const { return made_at_; }
  /// Its client has hung up, which the loop has not noticed yet.
  [[nodiscard]] bool forsaken() const { return forsaken_; }
  void forsake() { forsaken_ = true; }
  /// Why the report is to be given up; nullptr if it is not.
  [[nodiscard]] const char* overdue(std::uint64_t now) const {
    if (runs() && now - begun_ > kLongest) return "it takes more than 60 s";
    if (made_ && now > taken_at_ && now - taken_at_ > kUnread) return "it is not read";
    if (made_ && now > made_at_ && now - made_at_ > kLongest) return "it is not read within 60 s";
    return nullptr;
  }

  void start() {
    std::array<int, 2> ends{-1, -1};
    memory_ = Fd(::memfd_create("mlcca-report", MFD_CLOEXEC));
    if (!memory_ || ::pipe2(ends.data(), O_CLOEXEC) < 0) {
      fail(std::string("memory: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
      return;
    }
    // Nothing is written to the pipe. Its end shows that the child has ended.
    end_ = Fd(ends[0]);
    const Fd held_by_child(ends[1]);
    const pid_t parent = ::getpid();
    begun_ = monotonic_ns();
    child_ = ::fork();
    if (child_ == 0) be_child(memory_.get(), parent, make_, may_slice_);
    aside_.budget_.forked(user(), begun_, monotonic_ns());
    make_ = nullptr;
    if (child_ < 0) {
      fail(std::string("fork: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
      return;
    }
    sd_event_source* raw = nullptr;
    if (sd_event_add_io(aside_.loop_, &raw, end_.get(), EPOLLIN, on_end_of_child, this) < 0) {
      fail("the loop does not take it");
      return;
    }
    source_.reset(raw);
  }

  /// Gives up the report; the client gets an error with `why`.
  void fail(const std::string& why) {
    failed_ = "the report cannot be made: " + why;
    end();
    aside_.ready_(peer_.session);
  }

  std::optional<serve::Slice> next() {
    if (!failed_.empty()) return failure(failed_);
    if (!made_) return std::nullopt;
    Head head;
    if (!take(&head, sizeof head) ||
        head.bytes > std::max(kMostOfSlice, control::Reply::kMaxBytesUnsliced))
      return give_up("the process that makes it has ended");
    serve::Slice slice{{}, head.more != 0, std::string(head.bytes, '\0')};
    if (!take(slice.encoded.data(), slice.encoded.size()))
      return give_up("the process that makes it has ended");
    // Returns the memory of what has been read.
    static_cast<void>(::fallocate(memory_.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
                                  static_cast<off_t>(read_)));
    taken_at_ = monotonic_ns();
    if (!slice.more) end();
    return slice;
  }

 private:
  static int on_end_of_child(sd_event_source*, int, std::uint32_t, void* self) noexcept {
    static_cast<Report*>(self)->finish();
    return 0;
  }

  /// The child has ended, successfully or not: its place is free.
  void finish() {
    struct stat is{};
    source_.reset();
    end_ = Fd();
    made_ = true;
    made_at_ = taken_at_ = monotonic_ns();
    if (::fstat(memory_.get(), &is) == 0) size_ = static_cast<std::size_t>(is.st_size);
    aside_.ended(std::exchange(child_, 0), user());
    aside_.make_room_beside(*this);
    aside_.ready_(peer_.session);
  }

  /// Reads the next bytes. False if they are not there.
  bool take(void* to, std::size_t bytes) {
    auto* next = static_cast<char*>(to);
    while (bytes != 0) {
      const ssize_t n = ::pread(memory_.get(), next, bytes, static_cast<off_t>(read_));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      next += n;
      bytes -= static_cast<std::size_t>(n);
      read_ += static_cast<std::size_t>(n);
    }
    return true;
  }

  serve::Slice give_up(const std::string& why) {
    end();
    return failure("the report cannot be made: " + why);
  }

  /// Ends the report and its child.
  void end() {
    std::erase(aside_.reports_, this);
    source_.reset();
    end_ = Fd();
    memory_ = Fd();
    made_ = false;
    const pid_t child = std::exchange(child_, 0);
    if (child > 0) aside_.ended(child, user());
  }

  Aside& aside_;
  serve::Peer peer_;
  Make make_;
  bool may_slice_;
  pid_t child_ = 0;
  bool forsaken_ = false;
  std::uint64_t begun_ = 0;
  bool made_ = false;
  std::uint64_t made_at_ = 0;
  std::uint64_t taken_at_ = 0;  ///< when a slice was last read, or the report was made
  std::size_t size_ = 0;
  std::size_t read_ = 0;
  Fd memory_;  ///< what the child writes to
  Fd end_;     ///< readable once the child has ended
  Source source_;
  std::string failed_;
};

// --- all of them ---------------------------------------------------------------------------------

Aside::Aside(sd_event* loop, ForkBudget::Rates rates)
    : loop_(loop), budget_(rates), always_(::eventfd(1, EFD_CLOEXEC | EFD_NONBLOCK)) {
  sd_event_source* raw = nullptr;
  if (!always_ || sd_event_add_time(loop_, &raw, CLOCK_MONOTONIC, 0, 1, on_time, this) < 0) return;
  timer_.reset(std::exchange(raw, nullptr));
  sd_event_source_set_enabled(timer_.get(), SD_EVENT_OFF);
  if (sd_event_add_io(loop_, &raw, always_.get(), EPOLLIN, on_work, this) < 0) return;
  work_.reset(raw);
  sd_event_source_set_enabled(raw, SD_EVENT_OFF);
}

Aside::~Aside() { reap(); }

serve::NextSlice Aside::ask(const serve::Peer& peer, Make make, bool may_slice) {
  auto report = std::make_shared<Report>(*this, peer, std::move(make), may_slice);
  if (!work_) report->fail("the loop does not take it");
  plan();
  return [report = std::move(report)] { return report->next(); };
}

int Aside::on_work(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  auto& aside = *static_cast<Aside*>(self);
  if (aside.passes_++ < kPasses) return 0;
  aside.start_next();
  aside.plan();
  return 0;
}

int Aside::on_time(sd_event_source*, std::uint64_t, void* self) noexcept {
  static_cast<Aside*>(self)->plan();
  return 0;
}

int Aside::on_end(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  static_cast<Aside*>(self)->reap();
  static_cast<Aside*>(self)->plan();
  return 0;
}

/// The users whose children exist. A user has at most one.
std::vector<serve::Turns::User> Aside::busy() const {
  std::vector<serve::Turns::User> users;
  for (const Ended& one : ended_) users.push_back(one.user);
  for (const Report* r : reports_)
    if (r->runs()) users.push_back(r->user());
  return users;
}

/// The reports that wait only for the fork budget.
std::vector<Aside::Report*> Aside::waiting() const {
  const std::vector<serve::Turns::User> users = busy();
  std::vector<Report*> reports;
  if (users.size() >= kAtOnce) return reports;
  const auto has_room = [&users](const Report& r) {
    return std::ranges::find(users, r.uid(), &serve::Turns::User::uid) == users.end() &&
           std::cmp_less(std::ranges::count(users, r.user().member, &serve::Turns::User::member),
                         kOfStanding);
  };
  for (Report* r : reports_)
    if (r->waits() && has_room(*r)) reports.push_back(r);
  return reports;
}

/// The report that may begin next: of the members first, and of one group that of the user whose
/// latest report began the longest time ago.
Aside::Report* Aside::next(std::uint64_t now) {
  Report* next = nullptr;
  std::uint64_t oldest = ~0ULL;
  for (Report* r : waiting()) {
    if (budget_.ready_at(r->user(), now) > now) continue;
    const auto known = last_started_.find(r->uid());
    const std::uint64_t started = known == last_started_.end() ? 0 : known->second;
    const bool goes_before = next != nullptr && r->user().member != next->user().member
                                 ? r->user().member
                                 : started < oldest;
    if (!goes_before) continue;
    oldest = started;
    next = r;
  }
  return next;
}

void Aside::start_next() {
  passes_ = 0;
  const std::uint64_t now = monotonic_ns();
  Report* report = next(now);
  for (; report != nullptr && gone_ && gone_(report->peer().session); report = next(now))
    report->forsake();
  if (report == nullptr) return;
  last_started_[report->uid()] = now;
  report->start();
}

/// Schedules when the loop comes back to the waiting reports.
void Aside::plan() {
  if (!work_) return;
  const std::uint64_t now = monotonic_ns();
  std::uint64_t first = ~0ULL;
  for (const Report* r : waiting()) first = std::min(first, budget_.ready_at(r->user(), now));
  const bool at_once = first <= now;
  const bool later = !at_once && first != ~0ULL;
  if (!at_once) passes_ = 0;
  sd_event_source_set_enabled(work_.get(), at_once ? SD_EVENT_ON : SD_EVENT_OFF);
  if (later) sd_event_source_set_time(timer_.get(), first / 1000 + 1);
  sd_event_source_set_enabled(timer_.get(), later ? SD_EVENT_ONESHOT : SD_EVENT_OFF);
}

/// Kills the child. It counts as running until it has been waited for.
void Aside::ended(pid_t child, serve::Turns::User user) {
  ::kill(child, SIGKILL);
  Ended& one = ended_.emplace_back(child, user);
  // glibc has a wrapper only since 2.36. If the call fails, poll() waits for the child.
  // NOLINTNEXTLINE(*-vararg)
  one.process = Fd(static_cast<int>(::syscall(SYS_pidfd_open, child, 0)));
  sd_event_source* raw = nullptr;
  if (one.process && sd_event_add_io(loop_, &raw, one.process.get(), EPOLLIN, on_end, this) >= 0)
    one.source.reset(raw);
  reap();
  plan();
}

/// waitpid() returns 0 for a child that has not ended yet. Its memory is not free yet.
void Aside::reap() {
  std::erase_if(ended_,
                [](const Ended& one) { return ::waitpid(one.child, nullptr, WNOHANG) != 0; });
}

/// Makes room for a report that has just been made: the oldest reports of its user fail, then those
/// of its group of users, as far as they exceed the limits together.
void Aside::make_room_beside(const Report& fresh) {
  const auto shrink = [this](std::size_t most, auto concerns) {
    for (;;) {
      std::size_t sum = 0;
      Report* oldest = nullptr;
      for (Report* r : reports_) {
        if (r->kept() == 0 || !concerns(*r)) continue;
        sum += r->kept();
        if (oldest == nullptr || r->made_at() < oldest->made_at()) oldest = r;
      }
      if (sum <= most) return;
      oldest->fail("it is read so slowly that the next ones have no room");
    }
  };
  const serve::Turns::User user = fresh.user();
  shrink(kKeptOfUser, [user](const Report& r) { return r.uid() == user.uid; });
  shrink(kKept, [user](const Report& r) { return r.user().member == user.member; });
}

void Aside::poll() {
  reap();
  const std::uint64_t now = monotonic_ns();
  std::erase_if(last_started_, [now](const auto& u) { return now - u.second > kLongest; });
  budget_.tidy(now);
  for (Report* report : std::vector(reports_))
    if (const char* why = report->overdue(now)) report->fail(why);
  plan();
}

}  // namespace mlcca
