// SPDX-License-Identifier: BSD-2-Clause
// Folders are watched and not files: if an editor renames a new file over the old one, a watch on
// the file would follow the old one, which has lost its name.
#include "tools/design/check/watch.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): of POSIX
#include <sys/inotify.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>

namespace mlcca::tools::design {
namespace {

using Clock = std::chrono::steady_clock;

// A save is complete when nothing has happened for kQuiet; a file that never rests is read after
// kLongest.
constexpr std::chrono::milliseconds kQuiet{50};
constexpr std::chrono::milliseconds kLongest{1000};

// IN_CREATE does not suffice: the content is written later and ends with IN_CLOSE_WRITE.
constexpr std::uint32_t kSaved =
    IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE | IN_ATTRIB;

std::unexpected<Error> failed(std::string_view what) {
  return fail(fmt::format("{}: {}", what, std::strerror(errno)));
}

bool changed_since(const std::string& file, timespec since) {
  struct stat status{};
  return ::stat(file.c_str(), &status) == 0 &&
         std::tie(status.st_ctim.tv_sec, status.st_ctim.tv_nsec) >=
             std::tie(since.tv_sec, since.tv_nsec);
}

enum class Ready : std::uint8_t { nothing, events, signal };

/// Waits for at most `patience`; a negative one means no limit.
Result<Ready> wait_for(int events, int signals, std::chrono::milliseconds patience) {
  std::array<pollfd, 2> fds{pollfd{.fd = events, .events = POLLIN, .revents = 0},
                            pollfd{.fd = signals, .events = POLLIN, .revents = 0}};
  int polled = -1;
  do {
    polled = ::poll(fds.data(), fds.size(), static_cast<int>(patience.count()));
  } while (polled < 0 && errno == EINTR);
  if (polled < 0) return failed("poll");
  if (fds[1].revents != 0) {
    signalfd_siginfo taken{};
    if (::read(signals, &taken, sizeof taken) < 0) return failed("signalfd");
    return Ready::signal;
  }
  return fds[0].revents != 0 ? Ready::events : Ready::nothing;
}

}  // namespace

timespec file_time() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME_COARSE, &now);
  return now;
}

FileWatch::~FileWatch() = default;
FileWatch::FileWatch(FileWatch&&) noexcept = default;
FileWatch& FileWatch::operator=(FileWatch&&) noexcept = default;

Result<FileWatch> FileWatch::open() {
  sigset_t ending;
  ::sigemptyset(&ending);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&ending, signal);
  if (::sigprocmask(SIG_BLOCK, &ending, nullptr) != 0) return failed("sigprocmask");
  Fd signals(::signalfd(-1, &ending, SFD_CLOEXEC));
  if (!signals) return failed("signalfd");
  Fd events(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  if (!events) return failed("inotify");
  return FileWatch(std::move(events), std::move(signals));
}

/// Watches the folder of the file, or its nearest ancestor that exists.
Result<void> FileWatch::add(const std::string& file) {
  const std::filesystem::path path(file);
  auto folder = path.parent_path();
  bool exists = true;
  for (;;) {
    const auto text = folder.empty() ? std::string(".") : folder.native();
    // IN_MASK_ADD: the same folder may be watched for another file, for other events.
    const int watch = ::inotify_add_watch(events_.get(), text.c_str(),
                                          IN_MASK_ADD | kSaved | (exists ? 0U : IN_CREATE));
    if (watch >= 0) {
      folders_[watch].names.insert(path.filename().native());
      folders_[watch].any = folders_[watch].any || !exists;
      return {};
    }
    const bool higher = (errno == ENOENT || errno == ENOTDIR || errno == EACCES) &&
                        !folder.empty() && folder.has_relative_path();
    if (!higher) return failed(text);
    folder = folder.parent_path();
    exists = false;
  }
}

Result<bool> FileWatch::follow(const std::vector<std::string>& files, timespec since) {
  const auto old = std::exchange(folders_, {});
  const auto known = std::exchange(files_, {files.begin(), files.end()});
  for (const auto& file : files_) {
    if (auto added = add(file); !added) return std::unexpected(added.error());
    // The target of a symbolic link is watched, too: an editor saves there.
    std::error_code gone;
    const auto real = std::filesystem::canonical(file, gone);
    if (gone) continue;
    if (auto added = add(real.native()); !added) return std::unexpected(added.error());
  }
  for (const auto& [watch, folder] : old)
    if (!folders_.contains(watch)) ::inotify_rm_watch(events_.get(), watch);
  return std::ranges::any_of(files_, [&](const std::string& file) {
    return !known.contains(file) && changed_since(file, since);
  });
}

/// Reads the pending events; true if one of them concerns a watched name.
Result<bool> FileWatch::take_events() {
  bool counts = false;
  alignas(inotify_event) std::array<char, 65536> buffer{};
  for (;;) {
    const auto size = ::read(events_.get(), buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return counts;
    if (size <= 0) return failed("inotify");
    for (std::size_t at = 0; at < static_cast<std::size_t>(size);) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      at += sizeof(inotify_event) + event->len;
      const auto folder = folders_.find(event->wd);
      const bool lost = (event->mask & (IN_Q_OVERFLOW | IN_UNMOUNT)) != 0;
      counts = counts || lost ||
               (folder != folders_.end() &&
                (folder->second.any || (event->mask & IN_IGNORED) != 0 ||
                 (event->len != 0 && folder->second.names.contains(event->name))));
    }
  }
}

Result<Woken> FileWatch::wait() {
  for (;;) {
    const auto ready = wait_for(events_.get(), signals_.get(), std::chrono::milliseconds(-1));
    if (!ready) return std::unexpected(ready.error());
    if (*ready == Ready::signal) return Woken::ended;
    const auto counts = take_events();
    if (!counts) return std::unexpected(counts.error());
    if (*counts) break;
  }
  const auto longest = Clock::now() + kLongest;
  while (Clock::now() < longest) {
    const auto ready = wait_for(events_.get(), signals_.get(), kQuiet);
    if (!ready) return std::unexpected(ready.error());
    if (*ready == Ready::signal) return Woken::ended;
    if (*ready == Ready::nothing) break;
    if (const auto more = take_events(); !more) return std::unexpected(more.error());
  }
  return Woken::changed;
}

}  // namespace mlcca::tools::design
