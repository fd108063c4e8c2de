// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sign_of_life.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace mlcca::tools {

bool is_pipe(int fd) {
  struct stat is{};
  return ::fstat(fd, &is) == 0 && (S_ISFIFO(is.st_mode) || S_ISSOCK(is.st_mode));
}

bool discard_input(int fd) {
  std::array<char, 4096> unused{};
  const auto n = ::read(fd, unused.data(), unused.size());
  return n > 0 || (n < 0 && (errno == EINTR || errno == EAGAIN));
}

}  // namespace mlcca::tools
