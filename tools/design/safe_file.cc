// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/safe_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "base/handle.hpp"

namespace mlcca::tools::design {
std::string existing_words(const std::string& path) {
  return path + " exists, and nothing is overwritten: name another file";
}

namespace {

std::unexpected<Error> failed(const std::string& path, const char* what) {
  return fail(fmt::format("{}: {}: {}", path, what, ::strerror(errno)));
}

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

/// Waits until a descriptor that does not block, for example of a terminal that another program has
/// set so, has more. Keeps errno.
void await_more(int fd) {
  const int error = errno;
  pollfd waits{.fd = fd, .events = POLLIN, .revents = 0};
  static_cast<void>(::poll(&waits, 1, -1));
  errno = error;
}

Result<std::string> read_all(int fd, const std::string& path, std::size_t limit) {
  std::string text;
  for (;;) {
    const std::size_t had = text.size();
    text.resize(had + 65536);
    const auto n = ::read(fd, text.data() + had, 65536);
    if (n < 0 && errno == EAGAIN) await_more(fd);
    if (n < 0 && errno != EINTR && errno != EAGAIN) return failed(path, "read");
    text.resize(had + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    if (n == 0) return text;
    if (text.size() > limit)
      return fail(fmt::format("{}: is larger than {} bytes; that is the limit", path, limit));
  }
}

/// A temporary file beside its target; it is removed unless it has become the target.
class Draft {
 public:
  explicit Draft(const std::string& target) : target_(target), name_(target + ".XXXXXX") {}
  ~Draft() {
    if (there_) ::unlink(name_.c_str());
  }
  Draft(const Draft&) = delete;
  Draft(Draft&&) = delete;
  Draft& operator=(const Draft&) = delete;
  Draft& operator=(Draft&&) = delete;

  Result<void> open() {
    fd_.reset(::mkostemp(name_.data(), O_CLOEXEC));
    if (!fd_) return failed(target_, "create");
    there_ = true;
    return {};
  }

  Result<void> keep_owner_and_mode(const struct stat& of) {
    struct stat own{};
    if (::fstat(fd_.get(), &own) != 0) return failed(target_, "stat");
    const bool other = own.st_uid != of.st_uid || own.st_gid != of.st_gid;
    if (other && ::fchown(fd_.get(), of.st_uid, of.st_gid) != 0)
      return failed(target_, "cannot give the new file to the owner of the old one");
    return set_mode(of.st_mode & 07777U);
  }

  Result<void> set_mode(mode_t mode) {
    if (::fchmod(fd_.get(), mode) != 0) return failed(target_, "chmod");
    return {};
  }

  Result<void> write(std::string_view text) {
    while (!text.empty()) {
      const auto n = ::write(fd_.get(), text.data(), text.size());
      if (n < 0 && errno != EINTR) return failed(target_, "write");
      if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
    }
    return {};
  }

  Result<void> sync() {
    if (::fsync(fd_.get()) != 0) return failed(target_, "sync");
    return {};
  }

  /// Closes the descriptor: there may be more drafts than a process can have open files.
  void close() { fd_.reset(); }

  Result<void> become(const std::string& target, bool replace) {
    if (::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, target.c_str(),
                    replace ? 0U : static_cast<unsigned>(RENAME_NOREPLACE)) != 0) {
      if (errno == EEXIST) return fail(existing_words(target));
      return failed(target, "rename");
    }
    there_ = false;
    return {};
  }

 private:
  std::string target_;  ///< the file that errors name
  std::string name_;
  Fd fd_;
  bool there_ = false;
};

void sync_folder(const std::string& path) {
  const Fd folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder) ::fsync(folder.get());
}

bool is_same(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size &&
         a.st_mtim.tv_sec == b.st_mtim.tv_sec && a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

Result<void> draft_like(Draft& draft, const FileContent& old, std::string_view text) {
  if (auto done = draft.open(); !done) return done;
  if (auto done = draft.keep_owner_and_mode(old.status); !done) return done;
  return draft.write(text);
}

Result<void> draft_new(Draft& draft, std::string_view text) {
  if (auto done = draft.open(); !done) return done;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  if (auto done = draft.set_mode(0666U & ~mask); !done) return done;
  return draft.write(text);
}

Result<void> put(Draft& draft, const FileContent& old) {
  struct stat now{};
  if (::stat(old.path.c_str(), &now) != 0 || !is_same(now, old.status))
    return fail(old.path + ": has been changed by someone else meanwhile; nothing was written");
  return draft.become(old.path, true);
}

}  // namespace

Result<std::optional<FileContent>> read_file(const std::string& path, std::size_t limit,
                                             Links links) {
  // O_NONBLOCK: a pipe is refused, not waited for.
  const int follow = links == Links::follow ? 0 : O_NOFOLLOW;
  const Fd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | follow));
  if (!fd && errno == ENOENT) {
    // A dangling link would be replaced by a file.
    struct stat link{};
    if (::lstat(path.c_str(), &link) == 0)
      return fail(fmt::format("{}: is a symbolic link that leads nowhere", path));
    return std::optional<FileContent>();
  }
  FileContent result;
  if (!fd || ::fstat(fd.get(), &result.status) != 0) return failed(path, "open");
  if (!S_ISREG(result.status.st_mode)) return fail(path + ": is not a regular file");
  auto text = read_all(fd.get(), path, limit);
  if (!text) return std::unexpected(text.error());
  result.text = std::move(*text);
  if (links == Links::refuse) {
    result.path = path;
    return result;
  }
  const std::unique_ptr<char, FreeWith<std::free>> real(::realpath(path.c_str(), nullptr));
  if (!real) return failed(path, "resolve");
  result.path = real.get();
  return result;
}

Result<std::string> read_standard_input(std::size_t limit) {
  return read_all(STDIN_FILENO, "standard input", limit);
}

Result<void> replace_file(const FileContent& old, std::string_view text) {
  Draft draft(old.path);
  if (auto done = draft_like(draft, old, text); !done) return done;
  if (auto done = draft.sync(); !done) return done;
  if (auto done = put(draft, old); !done) return done;
  sync_folder(folder_of(old.path));
  return {};
}

Result<void> create_file(const std::string& path, std::string_view text) {
  Draft draft(path);
  if (auto done = draft_new(draft, text); !done) return done;
  if (auto done = draft.sync(); !done) return done;
  if (auto done = draft.become(path, false); !done) return done;
  sync_folder(folder_of(path));
  return {};
}

struct FileBatch::Pending {
  Draft draft;
  std::string path;
  std::optional<FileContent> old;  ///< the file that is replaced
};

FileBatch::FileBatch(std::string folder) : folder_(std::move(folder)) {}
FileBatch::~FileBatch() = default;

Result<void> FileBatch::replace(FileContent old, std::string_view text) {
  const std::string path = old.path;
  auto& next = *pending_.emplace_back(new Pending{Draft(path), path, std::move(old)});
  auto done = draft_like(next.draft, *next.old, text);
  next.draft.close();
  return done;
}

Result<void> FileBatch::create(const std::string& path, std::string_view text) {
  auto& next = *pending_.emplace_back(new Pending{Draft(path), path, std::nullopt});
  auto done = draft_new(next.draft, text);
  next.draft.close();
  return done;
}

Result<void> FileBatch::commit() {
  if (pending_.empty()) return {};
  const Fd folder(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || ::syncfs(folder.get()) != 0) return failed(folder_, "sync");
  for (const auto& next : pending_) {
    auto done = next->old ? put(next->draft, *next->old) : next->draft.become(next->path, false);
    if (!done) return done;
  }
  ::fsync(folder.get());
  pending_.clear();
  return {};
}

}  // namespace mlcca::tools::design
