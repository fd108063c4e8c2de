// SPDX-License-Identifier: BSD-2-Clause
#include "client/connection.hpp"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <variant>

#include "base/unix_address.hpp"
#include "client/answers.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"

namespace mlcca::client {
namespace {

constexpr std::size_t kReadSize = std::size_t{64} << 10;
/// Exceptions that wait for a program that does not call process(); a reader of the connection
/// alone cannot make more of them wait than come in one turn.
constexpr std::size_t kMostNotices = 4096;

std::string text_of(int error) { return std::strerror(error); }  // NOLINT(concurrency-mt-unsafe)

void add_to(const Fd& epoll, const Fd& fd, std::uint32_t events) {
  epoll_event event{.events = events, .data = {.fd = fd.get()}};
  if (::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd.get(), &event) != 0)
    throw std::system_error(errno, std::system_category(), "epoll_ctl");
}

void set_timer(const Fd& timer, std::chrono::milliseconds time) {
  constexpr long in_a_second = 1000;
  constexpr long in_a_milli = 1'000'000;
  itimerspec at{};
  at.it_value.tv_sec = time.count() / in_a_second;
  at.it_value.tv_nsec = time.count() % in_a_second * in_a_milli;
  ::timerfd_settime(timer.get(), 0, &at, nullptr);
}

}  // namespace

Client::Connection::Connection(Options options)
    : options_(std::move(options)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      noticed_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!epoll_ || !timer_ || !noticed_)
    throw std::system_error(errno, std::system_category(), "a connection to mlccad");
  options_.first_retry = std::max(options_.first_retry, std::chrono::milliseconds(1));
  options_.longest_retry = std::max(options_.longest_retry, options_.first_retry);
  retry_ = options_.first_retry;
  add_to(epoll_, timer_, EPOLLIN);
  add_to(epoll_, noticed_, EPOLLIN);
}

// --- made and lost -------------------------------------------------------------------------------

void Client::Connection::connect() {
  if (socket_) return;
  set_timer(timer_, std::chrono::milliseconds(0));
  const auto address = unix_address(options_.socket);
  if (!address) {
    lose(address.error().text);
    return;
  }
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket || ::connect(socket.get(), generic(*address), sizeof *address) != 0) {
    lose("no daemon: " + options_.socket + ": " + text_of(errno));
    return;
  }
  socket_ = std::move(socket);
  add_to(epoll_, socket_, EPOLLIN);
  for (const PartOf& part : parts()) ask(part);
  flush();
}

/// Whatever was under way is gone; it is tried again after a while.
void Client::Connection::lose(const std::string& why) {
  socket_.reset();
  in_ = control::Buffer();
  out_.clear();
  asked_.clear();
  set_timer(timer_, retry_);
  retry_ = std::min(retry_ * 2, options_.longest_retry);
  for (const PartOf& part : parts()) {
    part->asked = 0;
    part->waiting.clear();
    const bool was_told =
        part->answer.state != State::no_daemon && part->answer.state != State::unannounced;
    part->lost = true;
    part->answer = {.state = State::no_daemon, .reason = why, .deliveries = {}};
    if (was_told)
      note(part, {.cause = Cause::daemon_gone,
                  .text = why,
                  .silent = {},
                  .missing_events = 0,
                  .answer = part->answer});
  }
}

// --- channels ------------------------------------------------------------------------------------

std::vector<Client::Connection::PartOf> Client::Connection::parts() {
  std::erase_if(parts_, [](const auto& part) { return part.expired(); });
  std::vector<PartOf> all;
  for (const auto& part : parts_)
    if (PartOf one = part.lock()) all.push_back(std::move(one));
  return all;
}

void Client::Connection::add(const PartOf& part) {
  const auto all = parts();
  if (std::ranges::find(all, part) == all.end()) parts_.push_back(part);
}

void Client::Connection::take_up(const PartOf& part) {
  add(part);
  part->lost = false;
  if (!socket_)
    connect();
  else if (part->asked == 0)
    ask(part);
  const auto end = Clock::now() + options_.patience;
  for (turn(); part->asked != 0; turn()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) break;
    wait_for_daemon(left);
  }
  if (part->asked == 0) return;
  part->lost = true;  // the answer may come later
  part->answer = {
      .state = State::no_daemon,
      .reason = "no answer from mlccad within " + std::to_string(options_.patience.count()) + " ms",
      .deliveries = {}};
}

void Client::Connection::ask(const PartOf& part) {
  part->asked = ++last_id_;
  asked_.emplace(part->asked, Asked{part, {}});
  out_ += control::encode(control::Request{part->asked, part->request, true});
}

/// There is something for handlers.
void Client::Connection::wake() {
  const std::uint64_t one = 1;
  static_cast<void>(::write(noticed_.get(), &one, sizeof one) < 0);
}

void Client::Connection::note(const PartOf& part, Exception exception) {
  wake();
  if (notices_.size() == kMostNotices) {
    notices_.back() = {part,
                       {.cause = Cause::lagged,
                        .text = "exceptions were lost: process() is called too seldom",
                        .silent = {},
                        .missing_events = 0,
                        .answer = part->answer}};
    return;
  }
  notices_.push_back({part, std::move(exception)});
}

// --- bytes ---------------------------------------------------------------------------------------

void Client::Connection::turn() {
  std::uint64_t expired = 0;
  const bool due = ::read(timer_.get(), &expired, sizeof expired) == sizeof expired;
  if (!socket_ && due) connect();
  if (socket_) flush();
  if (socket_) receive();
  if (socket_) flush();
}

void Client::Connection::receive() {
  while (socket_) {
    const auto room = in_.space(kReadSize);
    const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return;
    if (n > 0) {
      in_.commit(static_cast<std::size_t>(n));
      take_replies();
    } else {
      lose(n == 0 ? "mlccad closed the connection" : text_of(errno));
    }
  }
}

/// Those that are whole.
void Client::Connection::take_replies() {
  while (socket_) {
    auto reply = control::decode_reply(in_);
    if (reply && !*reply) return;
    if (reply)
      on_reply(std::move(**reply));
    else
      lose(reply.error().text);
  }
}

void Client::Connection::flush() {
  while (!out_.empty()) {
    const ssize_t n = ::send(socket_.get(), out_.data(), out_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) break;
    // What the daemon has said before it closed is read first.
    if (n < 0) break;
    out_.erase(0, static_cast<std::size_t>(n));
  }
  watch();
}

void Client::Connection::watch() {
  epoll_event event{.events = EPOLLIN | (out_.empty() ? 0U : EPOLLOUT),
                    .data = {.fd = socket_.get()}};
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, socket_.get(), &event);
}

void Client::Connection::wait(std::chrono::milliseconds time) const {
  constexpr std::chrono::milliseconds longest(1'000'000'000);
  pollfd waits{.fd = epoll_.get(), .events = POLLIN, .revents = 0};
  ::poll(&waits, 1, time.count() < 0 ? -1 : static_cast<int>(std::min(time, longest).count()));
}

/// Whatever there is for handlers.
void Client::Connection::wait_for_daemon(std::chrono::milliseconds time) const {
  const auto events = static_cast<short>(POLLIN | (out_.empty() ? 0 : POLLOUT));
  pollfd waits{.fd = socket_.get(), .events = events, .revents = 0};
  ::poll(&waits, 1, static_cast<int>(time.count()));
}

// --- what comes ----------------------------------------------------------------------------------

void Client::Connection::on_reply(control::Reply reply) {
  if (const auto* event = std::get_if<control::Event>(&reply.body)) {
    on_event(*event);
    return;
  }
  if (reply.id == 0) {
    const auto* error = std::get_if<control::Error>(&reply.body);
    lose(error == nullptr ? "mlccad sent a reply without a request" : error->message);
    return;
  }
  const auto found = asked_.find(reply.id);
  if (found == asked_.end()) return;
  if (const auto joined = control::join(found->second.whole, std::move(reply)); !joined) {
    lose(joined.error().text);
    return;
  }
  if (found->second.whole->more) return;
  const Asked asked = std::move(found->second);
  asked_.erase(found);
  retry_ = options_.first_retry;
  // One that was asked for again has an answer that is newer.
  if (const PartOf part = asked.part.lock(); part && part->asked == asked.whole->id)
    on_answer(part, *asked.whole);
}

void Client::Connection::on_answer(const PartOf& part, const control::Reply& reply) {
  part->asked = 0;
  const Answer before = std::exchange(part->answer, answer_of(reply));
  if (const auto* channels = std::get_if<control::Channels>(&reply.body);
      channels != nullptr && !channels->channels.empty())
    part->subject = channels->channels.front().subject;
  if (std::exchange(part->lost, false))
    note(part, {.cause = Cause::daemon_back,
                .text = part->answer.reason,
                .silent = {},
                .missing_events = 0,
                .answer = part->answer});
  // Events are of all ends of a channel.
  const auto events = std::exchange(part->waiting, {});
  if (same_verdicts(before, part->answer)) return;
  for (const control::Event& event : events) note(part, exception_of(event, before, part->answer));
}

void Client::Connection::on_event(const control::Event& event) {
  for (const PartOf& part : parts()) {
    // Without a delivery only the name is known.
    const bool ours = event.subject != 0 &&
                      (event.subject == part->subject || event.channel == part->request.channel);
    const bool to_all = event.subject == 0;
    if (!ours && !to_all) continue;
    if (ours && changes_verdicts(event)) {
      // What is decided is asked for once more: an answer that is under way may be an older one.
      part->waiting.push_back(event);
      ask(part);
    } else {
      note(part, exception_of(event, part->answer, part->answer));
    }
  }
}

void Client::Connection::call_handlers() {
  std::uint64_t count = 0;
  static_cast<void>(::read(noticed_.get(), &count, sizeof count) < 0);
  // Not those that come while a handler runs: they are for the next turn.
  for (std::size_t left = notices_.size(); left != 0 && !notices_.empty(); --left) {
    const Notice notice = std::move(notices_.front());
    notices_.pop_front();
    const PartOf part = notice.part.lock();
    if (!part || !part->handler) continue;
    const Channel::Handler handler = part->handler;  // which may replace it
    if (left > 1) wake();                            // should it throw
    handler(notice.exception);
  }
}

}  // namespace mlcca::client
