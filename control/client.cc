// SPDX-License-Identifier: BSD-2-Clause
// A request is sent by one write; replies are read in large pieces and decoded once complete.
#include "control/client.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/unix_address.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"

namespace mlcca::control {
namespace {

constexpr std::size_t kReadSize = 64UL * 1024;

std::unexpected<mlcca::Error> cannot_connect(const std::string& path, int error) {
  const std::string cause = path + ": " + ::strerror(error);
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return fail("no daemon: " + cause);
    case ECONNREFUSED:
      return fail("no daemon listens: " + cause);
    case EAGAIN:
      return fail("the daemon does not answer: " + path);
    case EACCES:
    case EPERM:
      return fail("not permitted to ask the daemon: " + cause);
    default:
      return fail("connect " + cause);
  }
}

/// Waits without a time limit until a descriptor is readable or closed. Returns whether it is
/// `first`.
Result<bool> wait_for_either(int first, int second) {
  std::array<pollfd, 2> waiting{pollfd{.fd = first, .events = POLLIN, .revents = 0},
                                pollfd{.fd = second, .events = POLLIN, .revents = 0}};
  while (::poll(waiting.data(), waiting.size(), -1) < 0)
    if (errno != EINTR) return fail(std::string("wait for mlccad: ") + ::strerror(errno));
  return waiting[0].revents != 0;
}

Result<std::optional<Event>> event_of(Reply reply) {
  if (auto* event = std::get_if<Event>(&reply.body)) return std::move(*event);
  if (const auto* error = std::get_if<Error>(&reply.body)) return fail(error->message);
  return fail("mlccad sent a reply without a request");
}

}  // namespace

Result<Client> Client::connect(const std::string& path, std::chrono::milliseconds patience) {
  const auto address = unix_address(path);
  if (!address) return std::unexpected(address.error());
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!socket) return fail(std::string("socket: ") + ::strerror(errno));
  Client client(std::move(socket), patience);
  if (::connect(client.socket_.get(), generic(*address), sizeof *address) != 0)
    return cannot_connect(path, errno);
  return client;
}

Client::Client(Fd socket, std::chrono::milliseconds patience)
    : socket_(std::move(socket)), patience_(patience) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(patience);
  const timeval limit{.tv_sec = seconds.count(),
                      .tv_usec = std::chrono::microseconds(patience - seconds).count()};
  // This also limits connect(): a stopped daemon no longer accepts. It cannot fail on a socket.
  ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  ::setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

Result<Reply> Client::call(Request request) {
  request.id = ++last_id_;
  request.slices = true;
  const auto bytes = encode(request);
  if (bytes.size() > Request::kMaxBytes)
    return fail("the request has " + std::to_string(bytes.size()) + " bytes, at most " +
                std::to_string(Request::kMaxBytes) + " are possible");
  const auto sent = send(bytes);
  std::optional<Reply> whole;
  for (;;) {
    auto reply = receive();
    // A request that was not sent completely may have an answer: the daemon refused it and closed.
    if (!reply) return sent ? std::move(reply) : std::unexpected(sent.error());
    if (auto* event = std::get_if<Event>(&reply->body)) {
      events_.push_back(std::move(*event));
      continue;
    }
    const bool about_the_stream = reply->id == 0 && std::holds_alternative<Error>(reply->body);
    if (about_the_stream) return reply;
    if (reply->id == request.id) {
      if (const auto joined = join(whole, std::move(*reply)); !joined)
        return std::unexpected(joined.error());
      if (whole->more) continue;
      return std::move(*whole);
    }
    return fail("mlccad answered request " + std::to_string(reply->id) + " instead of " +
                std::to_string(request.id));
  }
}

Result<Event> Client::next_event() {
  for (;;) {
    auto event = next_event_unless(-1);
    if (!event) return std::unexpected(std::move(event).error());
    if (auto& one = *event; one) return std::move(*one);
  }
}

Result<std::optional<Event>> Client::next_event_unless(int other) {
  for (;;) {
    if (!events_.empty()) {
      auto event = std::move(events_.front());
      events_.pop_front();
      return event;
    }
    auto reply = decode_reply(received_);
    if (!reply) return std::unexpected(std::move(reply).error());
    if (auto& whole = *reply; whole) return event_of(std::move(*whole));
    const auto ready = wait_for_either(socket_.get(), other);
    if (!ready) return std::unexpected(ready.error());
    if (!*ready) return std::nullopt;
    if (const auto received = receive_bytes(); !received) return std::unexpected(received.error());
  }
}

Result<void> Client::send(const std::string& bytes) {
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const auto n = ::send(socket_.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
    if (n >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(n));
    } else if (errno == EAGAIN) {
      return fail(no_answer());
    } else if (errno != EINTR) {
      return fail(std::string("send to mlccad: ") + ::strerror(errno));
    }
  }
  return {};
}

Result<Reply> Client::receive() {
  for (;;) {
    auto reply = decode_reply(received_);
    if (!reply) return std::unexpected(std::move(reply).error());
    if (auto& whole = *reply; whole) return std::move(*whole);
    const auto received = receive_bytes();
    if (!received) return std::unexpected(received.error());
    if (!*received) return fail(no_answer());
  }
}

Result<bool> Client::receive_bytes() {
  for (;;) {
    const auto room = received_.space(kReadSize);
    const auto n = ::recv(socket_.get(), room.data(), room.size(), 0);
    if (n > 0) {
      received_.commit(static_cast<std::size_t>(n));
      return true;
    }
    if (n == 0) return fail("mlccad closed the connection");
    if (errno == EAGAIN) return false;
    if (errno != EINTR) return fail(std::string("receive from mlccad: ") + ::strerror(errno));
  }
}

std::string Client::no_answer() const {
  return "no answer from mlccad within " + std::to_string(patience_.count()) + " ms";
}

}  // namespace mlcca::control
