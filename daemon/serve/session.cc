// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/session.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "control/codec.hpp"

namespace mlcca::serve {

Session::Session(Server& server, Fd socket, Peer peer)
    : server_(server), socket_(std::move(socket)), peer_(peer) {}

std::unique_ptr<Session> Session::open(Server& server, Fd socket, Peer peer) {
  std::unique_ptr<Session> session(new Session(server, std::move(socket), peer));
  sd_event_source* raw = nullptr;
  if (sd_event_add_io(server.loop_, &raw, session->socket_.get(), EPOLLIN, &Session::on_io,
                      session.get()) < 0)
    return nullptr;
  session->source_.reset(raw);
  return session;
}

int Session::on_io(sd_event_source*, int fd, std::uint32_t events, void* userdata) noexcept {
  auto& session = *static_cast<Session*>(userdata);
  bool alive = true;
  if ((events & EPOLLOUT) != 0) alive = session.flush() && session.answer_pending();
  if (alive && (events & (EPOLLIN | EPOLLHUP | EPOLLERR)) != 0) alive = session.receive();
  if (alive)
    session.watch();
  else
    session.server_.drop(fd);
  return 0;
}

bool Session::receive() {
  const auto room = in_.space();
  const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
  if (n == 0) return false;
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  in_.commit(static_cast<std::size_t>(n));
  return answer_pending();
}

bool Session::answer_pending() {
  more_ = false;
  for (int answered = 0; !closing_ && out_.size() - sent_ < kBusy && held_.size() < kMostHeld;
       ++answered) {
    if (answered == kTurn) {
      more_ = true;
      break;
    }
    auto request = control::decode_request(in_);
    if (!request) {
      refuse(request.error().text);
      break;
    }
    if (!*request) break;
    if (std::holds_alternative<control::MonitorRequest>((*request)->body)) monitoring_ = true;
    take(server_.answer_(**request, peer_));
  }
  return flush();
}

void Session::take(Answer answer) {
  if (answer.held || !held_.empty()) {
    held_.push_back(std::move(answer));
    return;
  }
  if (answer.owned != 0) owned_.push_back(answer.owned);
  out_ += control::encode(answer.reply);
}

void Session::release(const Result<void>& done) {
  if (held_.empty()) return;
  for (Answer& answer : std::exchange(held_, {})) {
    if (answer.held && !done)
      answer.reply.body = control::Error{
          control::ErrorKind::world, "nothing was changed: " + done.error().text, {}};
    else if (answer.owned != 0)
      owned_.push_back(answer.owned);
    out_ += control::encode(answer.reply);
  }
  // A failed write shows at the next event of the socket. What was not read meanwhile is read then.
  more_ = true;
  flush();
  watch();
}

bool Session::wants(const control::Event& event) const {
  return monitoring_ || std::ranges::any_of(event.admissions, [this](std::uint64_t id) {
           return std::ranges::find(owned_, id) != owned_.end();
         });
}

void Session::refuse(std::string text) {
  out_ += control::encode(
      control::Reply{0, control::Error{control::ErrorKind::invalid, std::move(text), {}}});
  closing_ = true;
}

void Session::send_event(const std::string& encoded) {
  if (closing_) return;
  if (out_.size() - sent_ >= kBusy) {
    ++lost_events_;
    return;
  }
  if (lost_events_ != 0) {
    control::Event lagged;
    lagged.kind = "lagged";
    lagged.message = std::to_string(std::exchange(lost_events_, 0)) +
                     " events were not sent: this client reads too slowly";
    out_ += control::encode(control::Reply{0, lagged});
  }
  out_ += encoded;
  // A failed write shows at the next event of the socket, where the session can end.
  flush();
  watch();
}

bool Session::flush() {
  while (sent_ < out_.size()) {
    const ssize_t n = ::send(socket_.get(), out_.data() + sent_, out_.size() - sent_,
                             MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno == EAGAIN;
    sent_ += static_cast<std::size_t>(n);
  }
  out_.clear();
  sent_ = 0;
  return !closing_;
}

void Session::watch() {
  const bool waiting = sent_ < out_.size();
  const bool reading =
      !closing_ && !more_ && out_.size() - sent_ < kBusy && held_.size() < kMostHeld;
  sd_event_source_set_io_events(source_.get(),
                                (reading ? EPOLLIN : 0U) | (waiting || more_ ? EPOLLOUT : 0U));
}

}  // namespace mlcca::serve
