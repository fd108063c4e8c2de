// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/line_client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/epoll.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

#include "core/unix_address.hpp"

namespace mlcca::net {
namespace {

std::optional<std::uint16_t> parse_port(std::string_view text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc{} || end != text.data() + text.size() || port == 0) return std::nullopt;
  return port;
}

/// The sockets API takes every family through one type.
template <class Address>
Endpoint endpoint_of(const Address& address, std::string text) {
  static_assert(sizeof(Address) <= sizeof(sockaddr_storage));
  Endpoint out{.address = {}, .size = sizeof(Address), .text = std::move(text)};
  std::memcpy(&out.address, &address, sizeof(Address));
  return out;
}

Result<Endpoint> path_endpoint(const std::string& path) {
  const auto address = unix_address(path);
  if (!address) return std::unexpected(address.error());
  return endpoint_of(*address, path);
}

}  // namespace

Result<Endpoint> parse_endpoint(const std::string& text) {
  if (text.starts_with('/')) return path_endpoint(text);
  const auto colon = text.rfind(':');
  const auto port = colon == std::string::npos
                        ? std::nullopt
                        : parse_port(std::string_view(text).substr(colon + 1));
  if (port) {
    std::string host = text.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(*port);
    if (::inet_pton(AF_INET, host.c_str(), &v4.sin_addr) == 1) return endpoint_of(v4, text);
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(*port);
    if (::inet_pton(AF_INET6, host.c_str(), &v6.sin6_addr) == 1) return endpoint_of(v6, text);
  }
  return fail("\"" + text +
              "\" is no endpoint: HOST:PORT with a numeric host (127.0.0.1:2009, [::1]:33123) or "
              "the absolute path of a socket");
}

LineClient::LineClient(Endpoint endpoint, std::uint64_t pause, std::uint64_t patience,
                       Handlers handlers)
    : endpoint_(std::move(endpoint)),
      pause_(pause),
      patience_(patience),
      handlers_(std::move(handlers)) {}

Result<void> LineClient::start(sd_event* loop) {
  loop_ = loop;
  return timer_.start(loop, [this] { on_time(); });
}

void LineClient::on_time() {
  if (socket_)
    end("no answer for " + std::to_string(patience_ / 1'000'000) + " s");
  else
    connect();
}

void LineClient::connect() {
  timer_.set(patience_);
  if (const auto begun = begin_connecting(); !begun) end(begun.error().text);
}

Result<void> LineClient::begin_connecting() {
  socket_.reset(
      ::socket(endpoint_.address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket_) return fail(system_error("socket", errno));
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  const auto* address = reinterpret_cast<const sockaddr*>(&endpoint_.address);
  if (::connect(socket_.get(), address, endpoint_.size) < 0 && errno != EINPROGRESS)
    return fail(system_error("connecting", errno));
  sd_event_source* raw = nullptr;
  if (const int e = sd_event_add_io(loop_, &raw, socket_.get(), EPOLLOUT, on_io, this); e < 0)
    return fail(system_error("watching the connection", -e));
  io_.reset(raw);
  return {};
}

int LineClient::on_io(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  auto& client = *static_cast<LineClient*>(self);
  if (client.connected_) {
    client.receive();
    return 0;
  }
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(client.socket_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) {
    client.end(system_error("connecting", error));
    return 0;
  }
  client.connected_ = true;
  sd_event_source_set_io_events(client.io_.get(), EPOLLIN);
  client.handlers_.connected();
  return 0;
}

void LineClient::send(std::string_view request) {
  if (!connected_) return;
  const auto sent =
      ::send(socket_.get(), request.data(), request.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent != std::ssize(request)) end("it does not read its requests");
}

void LineClient::receive() {
  std::array<char, 16384> chunk{};
  const auto size = ::recv(socket_.get(), chunk.data(), chunk.size(), 0);
  if (size < 0) {
    if (errno != EAGAIN && errno != EINTR) end(system_error("receiving", errno));
    return;
  }
  if (size == 0) {
    const std::string rest = std::exchange(buffer_, {});
    if (!rest.empty()) handlers_.line(rest);
    if (socket_) end("");
    return;
  }
  timer_.set(patience_);
  buffer_.append(chunk.data(), static_cast<std::size_t>(size));
  if (take_lines() && buffer_.size() > kLongestLine) end("a line is too long");
}

bool LineClient::take_lines() {
  // A handler may end the connection, which empties the buffer: the text is kept here meanwhile.
  const std::string text = std::exchange(buffer_, {});
  std::size_t begin = 0;
  for (auto end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    handlers_.line(std::string_view(text).substr(begin, end - begin));
    if (!connected_) return false;
    begin = end + 1;
  }
  buffer_ = text.substr(begin);
  return true;
}

void LineClient::end(const std::string& why) {
  io_.reset();
  socket_.reset();
  connected_ = false;
  buffer_.clear();
  timer_.set(pause_);
  handlers_.ended(why);
}

}  // namespace mlcca::net
