// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/listen.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/unix_address.hpp"

namespace mlcca {

Result<Fd> listen_at(const std::string& path, int type, mode_t mode) {
  const auto address = unix_address(path);
  if (!address) return std::unexpected(address.error());
  const auto failed = [](const std::string& what) {
    return fail(what + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe): one thread
  };
  Fd socket(::socket(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return failed("socket");
  struct stat old{};
  if (::lstat(path.c_str(), &old) == 0 && S_ISSOCK(old.st_mode)) ::unlink(path.c_str());
  if (::bind(socket.get(), generic(*address), sizeof *address) < 0) return failed(path);
  if (mode != 0 && ::chmod(path.c_str(), mode) < 0) return failed(path);
  if (::listen(socket.get(), SOMAXCONN) < 0) return failed(path);
  return socket;
}

}  // namespace mlcca
