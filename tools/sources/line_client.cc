// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/line_client.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>

#include "base/system_error.hpp"

namespace mlcca::net {

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
    end("no complete answer for " + std::to_string(patience_ / 1'000'000) + " s");
  else
    connect();
}

void LineClient::connect() {
  timer_.set(patience_);
  if (const auto begun = begin_connecting(); !begun) end(begun.error().text);
}

Result<void> LineClient::begin_connecting() {
  auto listeners = trusted_listeners(endpoint_);
  if (!listeners) return std::unexpected(listeners.error());
  listeners_ = std::move(*listeners);
  socket_.reset(
      ::socket(endpoint_.address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket_) return system_error("socket");
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  const auto* address = reinterpret_cast<const sockaddr*>(&endpoint_.address);
  if (::connect(socket_.get(), address, endpoint_.size) < 0 && errno != EINPROGRESS)
    return system_error("connecting");
  sd_event_source* raw = nullptr;
  if (const int e = sd_event_add_io(loop_, &raw, socket_.get(), EPOLLOUT, on_io, this); e < 0)
    return system_error("watching the connection", -e);
  io_.reset(raw);
  return {};
}

/// Checks that the server is trusted and that the same socket listens as before connecting.
Result<void> LineClient::check_server() const {
  if (endpoint_.address.ss_family == AF_UNIX) return check_peer(socket_.get());
  const auto listeners = trusted_listeners(endpoint_);
  if (!listeners) return std::unexpected(listeners.error());
  if (listeners->empty())
    return fail("no socket of this machine listens there, so its owner is unknown");
  if (*listeners != listeners_) return fail("another socket listens there than a moment ago");
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
    client.end(error_words("connecting", error));
    return 0;
  }
  if (const auto checked = client.check_server(); !checked) {
    client.end(checked.error().text);
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

void LineClient::complete() {
  received_ = 0;
  timer_.set(patience_);
}

void LineClient::receive() {
  std::array<char, kTurn> chunk{};
  const auto size = ::recv(socket_.get(), chunk.data(), chunk.size(), 0);
  if (size < 0) {
    if (errno != EAGAIN && errno != EINTR) end(error_words("receiving", errno));
    return;
  }
  if (size == 0) {
    const std::string rest = std::exchange(buffer_, {});
    if (!rest.empty()) handlers_.line(rest);
    if (socket_) end("");
    return;
  }
  received_ += static_cast<std::size_t>(size);
  if (received_ > kLongestAnswer) {
    end("its answer is longer than " + std::to_string(kLongestAnswer) + " bytes");
    return;
  }
  buffer_.append(chunk.data(), static_cast<std::size_t>(size));
  if (take_lines() && buffer_.size() > kLongestLine)
    end("a line is longer than " + std::to_string(kLongestLine) + " bytes");
}

bool LineClient::take_lines() {
  // A handler may end the connection, which clears the buffer; so the text is kept here.
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
  received_ = 0;
  buffer_.clear();
  timer_.set(pause_);
  handlers_.ended(why);
}

}  // namespace mlcca::net
