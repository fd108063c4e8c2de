// SPDX-License-Identifier: BSD-2-Clause
#include "relay/daemon_link.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>
#include <variant>

#include "base/unix_address.hpp"
#include "control/codec.hpp"
#include "control/event_kinds.hpp"
#include "control/slices.hpp"

namespace mlcca::relay {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestRetry(1000);
/// Pause while the daemon does not read.
constexpr milliseconds kPauseOfSending(20);
constexpr std::size_t kReadSize = std::size_t{64} << 10U;
/// Slices accepted in one reply; each slice has some hundred rows at least.
constexpr std::size_t kMostSlices = 65'536;
constexpr std::size_t kMostRows = std::size_t{1} << 20U;

std::string text_of(int error) { return std::strerror(error); }  // NOLINT(concurrency-mt-unsafe)

bool add_to(const Fd& epoll, const Fd& fd) {
  epoll_event event{.events = EPOLLIN, .data = {.fd = fd.get()}};
  return ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd.get(), &event) == 0;
}

/// Whether a list that this program asks for has more rows than any gateway can have.
bool is_without_end(const control::Reply& reply) {
  if (const auto* some = std::get_if<control::Transfers>(&reply.body))
    return some->transfers.size() > kMostRows;
  const auto* some = std::get_if<control::Subscriptions>(&reply.body);
  return some != nullptr && some->onward.size() > kMostRows;
}

}  // namespace

Affects affected_by(const control::Event& event) {
  const auto* const kind = control::event_kind(event.kind);
  if (kind == nullptr || kind->decides == control::Decides::nothing) return Affects::nothing;
  if (kind->decides == control::Decides::all) return Affects::all;
  return event.subject != 0 ? Affects::subject : Affects::nothing;
}

DaemonLink::DaemonLink(std::string socket, Handlers handlers)
    : path_(std::move(socket)),
      handlers_(std::move(handlers)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
  add_to(epoll_, timer_);
}

// --- the connection ------------------------------------------------------------------------------

void DaemonLink::connect() {
  const auto address = unix_address(path_);
  if (!address) return lose(address.error().text);
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket || ::connect(socket.get(), generic(*address), sizeof *address) != 0 ||
      !add_to(epoll_, socket))
    return lose("no daemon: " + path_ + ": " + text_of(errno));
  socket_ = std::move(socket);
  if (std::exchange(reported_gone_, false)) handlers_.log("mlccad answers again");
  send({0, control::MonitorRequest{}});
  handlers_.connected();
  flush();
}

void DaemonLink::lose(const std::string& why) {
  if (!std::exchange(reported_gone_, true))
    handlers_.log(why + ": what is carried stays, and its gates decide");
  socket_.reset();
  in_ = control::Buffer();
  out_.clear();
  whole_.reset();
  handlers_.lost();
  set_timer(retry_);
  retry_ = std::min(retry_ * 2, kLongestRetry);
}

void DaemonLink::turn() {
  std::uint64_t expired = 0;
  const bool due = ::read(timer_.get(), &expired, sizeof expired) == sizeof expired;
  if (!socket_ && due)
    connect();
  else if (due)
    handlers_.timer();
  if (socket_) flush();
  if (socket_) receive();
  if (socket_) flush();
}

std::uint64_t DaemonLink::send(control::Request request) {
  request.id = ++last_id_;
  out_ += control::encode(request);
  return request.id;
}

void DaemonLink::flush() {
  while (!out_.empty()) {
    const ssize_t n = ::send(socket_.get(), out_.data(), out_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return set_timer(kPauseOfSending);
    // Read what the daemon has sent before it closed; then recv() reports the end of the
    // connection.
    if (n < 0) {
      out_.clear();
      ::shutdown(socket_.get(), SHUT_RDWR);
      return;
    }
    out_.erase(0, static_cast<std::size_t>(n));
  }
}

void DaemonLink::receive() {
  const auto room = in_.space(kReadSize);
  const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
  if (n < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (n <= 0) return lose(n == 0 ? "mlccad closed the connection" : text_of(errno));
  in_.commit(static_cast<std::size_t>(n));
  while (socket_) {
    auto reply = control::decode_reply(in_);
    if (reply && !*reply) return;
    if (!reply) return lose(reply.error().text);
    on_reply(std::move(**reply));
  }
}

void DaemonLink::on_reply(control::Reply reply) {
  if (const auto* event = std::get_if<control::Event>(&reply.body)) {
    handlers_.event(*event);
    return;
  }
  if (reply.id == 0) {
    const auto* error = std::get_if<control::Error>(&reply.body);
    lose(error == nullptr ? "mlccad sent a reply without a request" : error->message);
    return;
  }
  // Replies arrive in the order of the requests, so slices of two replies are never mixed.
  if (!whole_) slices_ = 0;
  if (const auto joined = control::join(whole_, std::move(reply)); !joined)
    return lose(joined.error().text);
  if (++slices_ > kMostSlices || is_without_end(*whole_))
    return lose("mlccad sent a list without end");
  if (whole_->more) return;
  handlers_.reply(*std::exchange(whole_, std::nullopt));
}

}  // namespace mlcca::relay
