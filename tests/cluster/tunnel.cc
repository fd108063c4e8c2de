// SPDX-License-Identifier: BSD-2-Clause
#include "tests/cluster/tunnel.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "base/loop_timer.hpp"
#include "base/unix_address.hpp"
#include "tests/support/require.hpp"

namespace mlcca::test {
namespace {

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

EventSource watched(sd_event* loop, int fd, sd_event_io_handler_t call, void* self) {
  sd_event_source* raw = nullptr;
  require(sd_event_add_io(loop, &raw, fd, EPOLLIN, call, self) >= 0, "sd_event_add_io");
  return EventSource(raw);
}

}  // namespace

Tunnel::Tunnel(sd_event* loop, int to)
    : loop_(loop), to_(to), listening_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  require(::bind(listening_.get(), generic, size) == 0 && ::listen(listening_.get(), 16) == 0 &&
              ::getsockname(listening_.get(), generic, &size) == 0,
          "a tunnel");
  port_ = ntohs(address.sin_port);
  connections_ = watched(loop_, listening_.get(), on_connection, this);
}

void Tunnel::hold(bool holds) {
  holds_ = holds;
  for (const Pair& pair : pairs_)
    for (const auto* source : {&pair.from_client, &pair.from_server})
      sd_event_source_set_enabled(source->get(), holds ? SD_EVENT_OFF : SD_EVENT_ON);
}

void Tunnel::fall_silent(std::size_t after, bool half_closes) {
  after_ = after;
  half_closes_ = half_closes;
}
void Tunnel::fall_silent(bool half_closes) {
  for (Pair& pair : pairs_) silence(pair, half_closes);
}
void Tunnel::silence(Pair& pair, bool half_closes) {
  pair.left = 0;
  pair.from_server.reset();
  if (half_closes) ::shutdown(pair.client.get(), SHUT_WR);
}

int Tunnel::on_connection(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  static_cast<Tunnel*>(self)->accept();
  return 0;
}
int Tunnel::on_octets(sd_event_source*, int fd, std::uint32_t, void* self) noexcept {
  static_cast<Tunnel*>(self)->pass(fd);
  return 0;
}

void Tunnel::accept() {
  Pair& pair = pairs_.emplace_back();
  pair.client = Fd(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  pair.server = Fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_in address = loopback(to_);
  require(pair.client && ::connect(pair.server.get(), reinterpret_cast<const sockaddr*>(&address),
                                   sizeof address) == 0,
          "the other end of a tunnel");
  pair.from_client = watched(loop_, pair.client.get(), on_octets, this);
  pair.from_server = watched(loop_, pair.server.get(), on_octets, this);
  if (holds_) hold(true);
  pair.left = after_;
  if (pair.left == 0) silence(pair, half_closes_);
}

void Tunnel::pass(int fd) {
  const auto pair = std::ranges::find_if(
      pairs_, [fd](const Pair& p) { return p.client.get() == fd || p.server.get() == fd; });
  const bool of_server = pair->server.get() == fd;
  std::array<char, 16384> octets{};
  const ssize_t n = ::recv(fd, octets.data(), octets.size(), 0);
  if (of_server && std::exchange(cuts_, false)) {
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    if (resets_) ::setsockopt(pair->client.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    pairs_.erase(pair);
    return;
  }
  if (n <= 0) {
    pairs_.erase(pair);
    return;
  }
  if (!of_server && pair->left == 0) return;
  const int to = of_server ? pair->client.get() : pair->server.get();
  const std::size_t most = of_server ? pair->left : octets.size();
  const std::size_t size = std::min(static_cast<std::size_t>(n), most);
  if (::send(to, octets.data(), size, MSG_NOSIGNAL) != static_cast<ssize_t>(size)) {
    pairs_.erase(pair);
    return;
  }
  if (!of_server) return;
  octets_of_server_ += size;
  pair->left -= size;
  if (pair->left == 0) silence(*pair, half_closes_);
}

SlowReader::SlowReader(const std::string& socket, std::vector<std::string> prefixes)
    : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
  namespace wire = cluster::wire;
  const auto address = unix_address(socket);
  require(::connect(socket_.get(), generic(*address), sizeof *address) == 0, "connect");
  for (const auto& message : {wire::message_of(wire::Hello{"t", "slow"}),
                              wire::message_of(wire::Follow{std::move(prefixes)})})
    require(::send(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL) > 0, "send");
}

void SlowReader::give_credit(std::uint32_t entries) {
  const auto message = cluster::wire::message_of(cluster::wire::Credit{entries});
  require(::send(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL) > 0, "send");
}

std::optional<ClusterMessage> SlowReader::next() {
  // Signs of life come while nothing else does.
  for (int tries = 0; tries < 500; ++tries) {
    pollfd readable{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&readable, 1, 10) != 1) continue;
    const ssize_t n = ::recv(socket_.get(), buffer_.data(), buffer_.size(), 0);
    if (n <= 0) return std::nullopt;
    auto read = reader_.take({buffer_.data(), static_cast<std::size_t>(n)});
    if (!read) return std::nullopt;
    entries_ += read->entries;
    if (!read->whole) continue;
    if (const auto* snapshot = std::get_if<ClusterSnapshot>(&*read->whole)) {
      revision_ = snapshot->revision;
      entries_ = 0;
    }
    return read->whole;
  }
  return std::nullopt;
}

}  // namespace mlcca::test
