// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/session.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "base/clock.hpp"
#include "base/many.hpp"
#include "control/codec.hpp"
#include "control/event_kinds.hpp"
#include "control/slices.hpp"

namespace mlcca::serve {
namespace {

std::optional<Slice> too_large() {
  return Slice{control::Error{control::ErrorKind::world,
                              "the reply has more than " +
                                  std::to_string(control::Reply::kMaxBytesUnsliced) +
                                  " bytes: ask for less, or for slices (Request.slices)",
                              {}}};
}

/// Whether the event concerns every channel of the gateway.
bool concerns_all(const control::Event& event) {
  const auto* const kind = control::event_kind(event.kind);
  return event.subject == 0 && kind != nullptr && kind->reach == control::Reach::everyone;
}

}  // namespace

Session::Session(Server& server, Fd socket, Peer peer)
    : server_(server),
      socket_(std::move(socket)),
      peer_(std::move(peer)),
      active_(monotonic_ns()) {}

std::unique_ptr<Session> Session::open(Server& server, Fd socket, Peer peer) {
  std::unique_ptr<Session> session(new Session(server, std::move(socket), std::move(peer)));
  sd_event_source* raw = nullptr;
  if (sd_event_add_io(server.loop_, &raw, session->socket_.get(), EPOLLIN, &Session::on_io,
                      session.get()) < 0)
    return nullptr;
  session->source_.reset(raw);
  return session;
}

int Session::on_io(sd_event_source*, int fd, std::uint32_t events, void* userdata) noexcept {
  auto& session = *static_cast<Session*>(userdata);
  Server& server = session.server_;
  bool alive = true;
  if ((events & EPOLLOUT) != 0) alive = session.flush();
  // A client that hangs up while its reply is being made, or while it waits for something, does not
  // want it any more.
  if (alive && (events & (EPOLLHUP | EPOLLERR)) != 0) alive = session.reads();
  if (alive && session.reads() && (events & (EPOLLIN | EPOLLHUP | EPOLLERR)) != 0)
    alive = session.receive();
  if (!alive)
    server.drop(fd);
  else if (session.can_step())
    server.ready(session);  // may end the session
  else
    session.watch();
  return 0;
}

bool Session::receive() {
  const auto room = in_.space();
  const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
  if (n == 0) return false;
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  in_.commit(static_cast<std::size_t>(n));
  has_work_ = true;
  return true;
}

void Session::step() {
  if (rest_) {
    step_slice();
    return;
  }
  auto request = control::decode_request(in_);
  if (!request) refuse(request.error().text);
  has_work_ = request && *request;
  if (!has_work_) return;
  active_ = monotonic_ns();
  const control::Request& asked = **request;
  if (const auto* monitor = std::get_if<control::MonitorRequest>(&asked.body)) {
    monitoring_ = true;
    exact_kinds_ = monitor->exact_kinds;
  }
  if (std::holds_alternative<control::AnnounceRequest>(asked.body)) announcing_ = true;
  take(server_.answer_(asked, peer_), asked.slices);
}

bool Session::follow(std::uint64_t subject) {
  if (followed_.size() >= kMostFollowed && !followed_.contains(subject)) return false;
  followed_.insert(subject);
  return true;
}

void Session::take(Answer answer, bool may_slice) {
  if (answer.follows && !follow(*answer.follows)) {
    answer.slices = nullptr;
    answer.reply.body =
        control::Error{control::ErrorKind::world,
                       "this connection follows " + std::to_string(kMostFollowed) +
                           " channels, which is the most: announce the others on another one",
                       {}};
  }
  if (answer.slices) {
    rest_ = Rest{std::move(answer.slices), answer.reply.id, may_slice};
    if (!may_slice && answer.least_bytes > control::Reply::kMaxBytesUnsliced)
      rest_->next = too_large;
    return;
  }
  if (answer.held || !held_.empty()) {
    held_.push_back(std::move(answer));
    return;
  }
  if (answer.owned != 0) owned_.insert(answer.owned);
  out_ += control::encode(answer.reply);
}

void Session::step_slice() {
  std::optional<Slice> slice = rest_->next();
  parked_ = !slice;
  if (parked_) return;
  if (slice->owned != 0) owned_.insert(slice->owned);
  if (!slice->encoded.empty()) {
    pass_on(*slice);
    return;
  }
  control::Reply reply{rest_->id, std::move(slice->body), slice->more};
  if (!rest_->may_slice) {
    if (!rest_->take(std::move(reply))) rest_->whole = control::Reply{rest_->id, too_large()->body};
    if (rest_->whole->more) return;
    reply = std::move(*rest_->whole);
  }
  out_ += control::encode(reply);
  if (!reply.more) {
    rest_.reset();
    active_ = monotonic_ns();
  }
}

/// Passes on a slice that another process has encoded. It costs the loop no more than copying its
/// bytes.
void Session::pass_on(const Slice& slice) {
  out_ += control::with_id(rest_->id, slice.encoded);
  if (slice.more) return;
  rest_.reset();
  active_ = monotonic_ns();
}

/// Adds a slice to the complete reply. False if it becomes too large.
bool Session::Rest::take(control::Reply slice) {
  bytes += control::encode(slice).size();
  return bytes <= control::Reply::kMaxBytesUnsliced && control::join(whole, std::move(slice));
}

void Session::release(const Result<void>& done) {
  if (held_.empty()) return;
  for (Answer& answer : std::exchange(held_, {})) {
    if (answer.held && !done)
      answer.reply.body = control::Error{
          control::ErrorKind::world, "nothing was changed: " + done.error().text, {}};
    else if (answer.owned != 0)
      owned_.insert(answer.owned);
    out_ += control::encode(answer.reply);
  }
  // A failed write shows at the next event of the socket. What was not read meanwhile is read then.
  flush();
  if (can_step()) server_.ready_later(*this);
  watch();
}

bool Session::wants(const control::Event& event) const {
  return monitoring_ || followed_.contains(event.subject) || (announcing_ && concerns_all(event)) ||
         std::ranges::any_of(event.admissions,
                             [this](std::uint64_t id) { return owned_.contains(id); });
}

void Session::refuse(std::string text) {
  out_ += control::encode(
      control::Reply{0, control::Error{control::ErrorKind::invalid, std::move(text), {}}});
  closing_ = true;
}

void Session::say_goodbye(const std::string& text) {
  out_ += control::encode(control::Reply{0, control::Error{control::ErrorKind::world, text, {}}});
  flush();
}

Use Session::use() const {
  const bool will_own =
      std::ranges::any_of(held_, [](const Answer& answer) { return answer.owned != 0; });
  if (will_own || !owned_.empty()) return Use::owns;
  if (rest_ || has_work_ || !held_.empty() || waiting() != 0) return Use::asks;
  return monitoring_ || announcing_ ? Use::listens : Use::idle;
}

void Session::send_event(const std::string& encoded) {
  if (closing_) return;
  if (waiting() >= kBusy) {
    ++lost_events_;
    return;
  }
  if (lost_events_ != 0) {
    control::Event lagged;
    lagged.kind = "lagged";
    lagged.message = many(std::exchange(lost_events_, 0), "event was", "events were") +
                     " not sent: this client reads too slowly";
    out_ += control::encode(control::Reply{0, lagged});
  }
  out_ += encoded;
  // A failed write shows at the next event of the socket, when the session can end.
  flush();
  watch();
}

bool Session::flush() {
  while (sent_ < out_.size()) {
    const ssize_t n = ::send(socket_.get(), out_.data() + sent_, out_.size() - sent_,
                             MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const bool later = errno == EAGAIN;
      out_.erase(0, std::exchange(sent_, 0));
      return later;
    }
    sent_ += static_cast<std::size_t>(n);
    active_ = monotonic_ns();
  }
  out_.clear();
  sent_ = 0;
  return !closing_;
}

void Session::watch() {
  sd_event_source_set_io_events(source_.get(),
                                (reads() ? EPOLLIN : 0U) | (waiting() != 0 ? EPOLLOUT : 0U));
}

}  // namespace mlcca::serve
