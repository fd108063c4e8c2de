// SPDX-License-Identifier: BSD-2-Clause
#include "base/listen.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/unix_address.hpp"

namespace mlcca {

Result<Fd> listen_at(const std::string& path, int type, mode_t mode, int backlog) {
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
  if (::listen(socket.get(), backlog) < 0) return failed(path);
  return socket;
}

Result<Fd> handed_over(int type) {
  const int given = ::sd_listen_fds(1);
  if (given > 1) return fail("systemd has handed over several sockets");
  if (given < 1) return Fd();
  Fd socket(SD_LISTEN_FDS_START);
  if (::sd_is_socket_unix(socket.get(), type, 1, nullptr, 0) <= 0)
    return fail("the socket from systemd is not of AF_UNIX, of another type, or does not listen");
  ::fcntl(socket.get(), F_SETFL, O_NONBLOCK);  // NOLINT(*-vararg)
  return socket;
}

}  // namespace mlcca
