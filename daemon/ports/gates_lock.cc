// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/gates_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "base/system_error.hpp"
#include "bpf/gate.h"

namespace mlcca {
namespace {

constexpr const char* kLock = "lock";

/// The owner is our user or root, or, if we are root, the user to whom root has given the bpffs.
bool is_trusted(uid_t owner, uid_t of_root) {
  return owner == 0 || owner == ::geteuid() || (::geteuid() == 0 && owner == of_root);
}

/// Checks an existing entry: another user who owns it could remove our pins.
Result<void> check_entry(int root_fd, const std::string& root, const std::string& name,
                         uid_t of_root) {
  struct stat there{};
  if (::fstatat(root_fd, name.c_str(), &there, AT_SYMLINK_NOFOLLOW) < 0)
    return errno == ENOENT ? Result<void>{} : system_error(root + "/" + name);
  if (!is_trusted(there.st_uid, of_root))
    return fail(
        fmt::format("{}/{} belongs to user {}: remove it, and mount the bpffs with mode=0750", root,
                    name, there.st_uid));
  return {};
}

Result<struct stat> check_root(int root_fd, const std::string& root) {
  struct stat there{};
  if (::fstat(root_fd, &there) < 0) return system_error(root);
  if (!is_trusted(there.st_uid, there.st_uid))
    return fail(fmt::format("{} belongs to user {}, and this is user {}: chown it", root,
                            there.st_uid, ::geteuid()));
  const bool others_write = (there.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  if (others_write && (there.st_mode & S_ISVTX) == 0)
    return fail(fmt::format("{} can be changed by others (mode {:04o}): chmod 0750", root,
                            there.st_mode & 07777U));
  return there;
}

/// Makes the directory as the first gate would; otherwise there would be nothing to lock until
/// then.
void make_folder_in_bpffs(const std::string& root) {
  const std::string above = std::filesystem::path(root).parent_path();
  struct statfs system{};
  if (::access(root.c_str(), F_OK) < 0 && errno == ENOENT &&
      ::statfs(above.c_str(), &system) == 0 && system.f_type == BPF_FS_MAGIC)
    static_cast<void>(::mkdir(root.c_str(), S_IRWXU));
}

}  // namespace

Result<Fd> lock_gates(const std::string& root) {
  make_folder_in_bpffs(root);
  Fd folder(::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));  // NOLINT(*-vararg)
  // NOLINTNEXTLINE(*-vararg)
  if (!folder && errno == ENOENT) folder.reset(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!folder) return system_error(root);
  struct statfs system{};
  if (::fstatfs(folder.get(), &system) < 0) return system_error(root);
  if (system.f_type != BPF_FS_MAGIC) return folder;  // no gates can be commanded there
  const auto owner = check_root(folder.get(), root);
  if (!owner) return std::unexpected(owner.error());
  for (const std::string& name :
       {std::string(kLock), fmt::format("v{}", GATE_LAYOUT_VERSION), std::string("early_programs")})
    if (auto fine = check_entry(folder.get(), root, name, owner->st_uid); !fine)
      return std::unexpected(fine.error());

  const std::string path = root + "/" + kLock;
  const bool made = ::mkdirat(folder.get(), kLock, S_IRWXU) == 0;
  if (!made && errno != EEXIST) return system_error(path);
  // NOLINTNEXTLINE(*-vararg)
  Fd lock(::openat(folder.get(), kLock, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!lock) return system_error(path);
  struct stat there{};
  if (::fstat(lock.get(), &there) < 0) return system_error(path);
  if (!is_trusted(there.st_uid, owner->st_uid))  // replaced between the calls
    return fail(fmt::format("{} belongs to user {}: remove it", path, there.st_uid));
  // What root makes manually must belong to the user of the service, as the bpffs does.
  if (there.st_uid != owner->st_uid && ::geteuid() == 0 &&
      ::fchown(lock.get(), owner->st_uid, owner->st_gid) < 0)
    return system_error(path);
  if ((there.st_mode & 07777U) != S_IRWXU && ::fchmod(lock.get(), S_IRWXU) < 0)
    return system_error(path);
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) < 0)
    return fail(root + ": another mlccad commands the gates there; they are left as they are");
  return lock;
}

Result<bool> keep_lock(Fd& lock, const std::string& root) {
  struct statfs system{};
  // No gates can be commanded there at present.
  if (::statfs(root.c_str(), &system) < 0 || system.f_type != BPF_FS_MAGIC) return false;
  struct stat held{};
  struct stat named{};
  if (::fstat(lock.get(), &held) < 0) return system_error(root + "/" + kLock);
  if (::lstat((root + "/" + kLock).c_str(), &named) == 0 && held.st_dev == named.st_dev &&
      held.st_ino == named.st_ino)
    return false;
  auto again = lock_gates(root);
  if (!again) return std::unexpected(again.error());
  lock = std::move(*again);
  return true;
}

}  // namespace mlcca
