// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/can_socket.hpp"

#include <fcntl.h>
#include <linux/can/raw.h>
#include <sys/socket.h>

#include <cerrno>
#include <optional>
#include <utility>

#include "base/passed_fd.hpp"
#include "base/system_error.hpp"
#include "daemon/net/sources/child.hpp"

namespace mlcca::net {
namespace {

int option_of(const Fd& socket, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  return ::getsockopt(socket.get(), SOL_SOCKET, option, &value, &size) == 0 ? value : -1;
}

}  // namespace

Result<void> make_sender(const Fd& socket) {
  if (option_of(socket, SO_DOMAIN) != AF_CAN || option_of(socket, SO_TYPE) != SOCK_RAW)
    return fail("not a raw socket of CAN");
  // Sockets of other CAN protocols do not have this option.
  if (::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0) != 0)
    return system_error("CAN_RAW_FILTER");
  if (::fcntl(socket.get(), F_SETFL, O_NONBLOCK) != 0) return system_error("O_NONBLOCK");
  return {};
}

CanSocket::State CanSocket::find_socket() {
  if (socket_) return State::ready;
  if (!way_) {
    Fd own(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
    if (own && make_sender(own)) {
      socket_ = std::move(own);
      return State::ready;
    }
    auto helper = connect_to_helper(helper_, "mlcca-can.socket");
    if (!helper) return note_missing(helper.error().text);
    way_ = std::move(helper->socket);
  }
  std::optional<Fd> passed = receive_fd(way_);
  if (!passed) return State::awaited;
  way_.reset();
  if (!*passed) return note_missing(helper_ + ": mlcca-can ended without handing over a socket");
  if (const auto done = make_sender(*passed); !done)
    return note_missing(helper_ + ": what was handed over is " + done.error().text);
  socket_ = std::move(*passed);
  problem_.clear();
  return State::ready;
}

CanSocket::State CanSocket::note_missing(std::string why) {
  problem_ = std::move(why);
  return State::missing;
}

bool CanSocket::send(std::uint32_t ifindex, const can_frame& frame) {
  const State state = find_socket();
  if (state != State::ready) return state == State::missing;
  sockaddr_can to{};
  to.can_family = AF_CAN;
  to.can_ifindex = static_cast<int>(ifindex);
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  const auto* const address = reinterpret_cast<const sockaddr*>(&to);
  static_cast<void>(
      ::sendto(socket_.get(), &frame, sizeof frame, MSG_DONTWAIT, address, sizeof to));
  return true;
}

}  // namespace mlcca::net
