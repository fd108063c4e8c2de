// SPDX-License-Identifier: BSD-2-Clause
// mlcca-can: opens a CAN socket that receives nothing and passes it to mlccad, whose unit does not
// permit opening one. Standard input is a connection to mlccad.
#include <linux/can/raw.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "base/handle.hpp"
#include "base/passed_fd.hpp"

namespace {

int failed(const char* what) {
  static_cast<void>(std::fprintf(stderr, "mlcca-can: %s: %s\n", what, std::strerror(errno)));
  return 1;
}

}  // namespace

int main(int argc, char**) {
  if (argc != 1) {
    static_cast<void>(
        std::fputs("usage: mlcca-can, with a connection to mlccad as standard input\n", stderr));
    return 2;
  }
  const mlcca::Fd socket(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  if (!socket) return failed("a socket of CAN");
  if (::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0) != 0)
    return failed("CAN_RAW_FILTER");
  return mlcca::send_fd(STDIN_FILENO, socket) ? 0 : failed("standard input");
}
