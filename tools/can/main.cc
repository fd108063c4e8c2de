// SPDX-License-Identifier: BSD-2-Clause
// mlcca-can: opens a CAN socket that receives nothing and passes it to mlccad, whose unit does not
// permit opening one. Standard input is a connection to mlccad.
#include <linux/can/raw.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "base/handle.hpp"
#include "base/passed_fd.hpp"
#include "base/standard_streams.hpp"

namespace {

int failed(const std::string& what) {
  mlcca::to_stderr("mlcca-can: " + what + ": " + std::strerror(errno) + '\n');
  return 1;
}

}  // namespace

int main(int argc, char**) {
  mlcca::keep_standard_streams();
  if (argc != 1) {
    mlcca::to_stderr("usage: mlcca-can, with a connection to mlccad as standard input\n");
    return 2;
  }
  const mlcca::Fd socket(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  if (!socket) return failed("a socket of CAN");
  if (::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0) != 0)
    return failed("CAN_RAW_FILTER");
  return mlcca::send_fd(STDIN_FILENO, socket) ? 0 : failed("standard input");
}
