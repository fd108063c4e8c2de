// SPDX-License-Identifier: BSD-2-Clause
#include "relay/grants.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>
#include <variant>

#include "base/unix_address.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"

namespace mlcca::relay {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry(100);
constexpr milliseconds kLongestRetry(1000);
/// Events come in bursts: one question follows all of a burst.
constexpr milliseconds kPause(20);
/// With more subjects all are asked for.
constexpr std::size_t kMostDue = 256;
constexpr std::size_t kMostUnsent = std::size_t{64} << 10;
constexpr std::size_t kReadSize = std::size_t{64} << 10;
constexpr std::size_t kMostTransfers = std::size_t{1} << 20;

/// What is decided of a subject may be otherwise.
constexpr std::array<std::string_view, 8> kDecisions{
    "granted", "refused", "withdrawn", "switched", "released", "reinstated", "binding", "local"};
/// All may be otherwise.
constexpr std::array<std::string_view, 5> kAll{"reload", "lagged", "interface", "mode", "started"};

std::string text_of(int error) { return std::strerror(error); }  // NOLINT(concurrency-mt-unsafe)

bool add_to(const Fd& epoll, const Fd& fd) {
  epoll_event event{.events = EPOLLIN, .data = {.fd = fd.get()}};
  return ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd.get(), &event) == 0;
}

}  // namespace

Grants::Grants(std::string socket, std::uint32_t user, Handlers handlers)
    : path_(std::move(socket)),
      user_(user),
      handlers_(std::move(handlers)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      retry_(kFirstRetry) {
  add_to(epoll_, timer_);
  connect();
}

void Grants::set_timer(milliseconds time) {
  constexpr long in_a_second = 1000;
  constexpr long in_a_milli = 1'000'000;
  itimerspec at{};
  at.it_value.tv_sec = time.count() / in_a_second;
  at.it_value.tv_nsec = time.count() % in_a_second * in_a_milli;
  ::timerfd_settime(timer_.get(), 0, &at, nullptr);
}

// --- the connection ------------------------------------------------------------------------------

void Grants::connect() {
  const auto address = unix_address(path_);
  if (!address) return lose(address.error().text);
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket || ::connect(socket.get(), generic(*address), sizeof *address) != 0 ||
      !add_to(epoll_, socket))
    return lose("no daemon: " + path_ + ": " + text_of(errno));
  socket_ = std::move(socket);
  if (std::exchange(reported_gone_, false)) handlers_.log("mlccad answers again");
  send({0, control::MonitorRequest{}});
  all_due_ = true;
  ask_next();
  flush();
}

void Grants::lose(const std::string& why) {
  if (!std::exchange(reported_gone_, true))
    handlers_.log(why + ": what is carried stays, and its gates decide");
  socket_.reset();
  in_ = control::Buffer();
  out_.clear();
  whole_.reset();
  due_.clear();
  asked_ = 0;
  set_timer(retry_);
  retry_ = std::min(retry_ * 2, kLongestRetry);
}

void Grants::turn() {
  std::uint64_t expired = 0;
  const bool due = ::read(timer_.get(), &expired, sizeof expired) == sizeof expired;
  if (!socket_ && due)
    connect();
  else if (due)
    ask_next();
  if (socket_) flush();
  if (socket_) receive();
  if (socket_) flush();
}

void Grants::ask_all() {
  all_due_ = true;
  if (socket_ && asked_ == 0) set_timer(kPause);
}

void Grants::ask_next() {
  if (asked_ != 0 || (!all_due_ && due_.empty())) return;
  control::TransfersRequest request{.channel = {}, .user = user_};
  of_subject_.reset();
  if (std::exchange(all_due_, false)) {
    due_.clear();
  } else {
    of_subject_ = *due_.begin();
    due_.erase(due_.begin());
    constexpr std::size_t digits = 16;
    std::string text(digits, '0');
    std::uint64_t rest = *of_subject_;
    for (auto digit = text.rbegin(); digit != text.rend(); ++digit, rest >>= 4U)
      *digit = "0123456789abcdef"[rest & 0xfU];
    request.channel = "0x" + text;
  }
  asked_ = last_id_ + 1;
  send({0, std::move(request), true});
}

void Grants::report(control::DelayRequest delay) {
  // What waits to be sent is bounded: a daemon that does not read is told less.
  if (!socket_ || !has_answer_ || out_.size() > kMostUnsent) return;
  send({0, std::move(delay)});
  flush();
}

void Grants::send(control::Request request) {
  request.id = ++last_id_;
  out_ += control::encode(request);
}

void Grants::flush() {
  while (!out_.empty()) {
    const ssize_t n = ::send(socket_.get(), out_.data(), out_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return set_timer(kPause);
    // What the daemon has said before it closed is read; then the connection ends.
    if (n < 0) {
      out_.clear();
      ::shutdown(socket_.get(), SHUT_RDWR);
      return;
    }
    out_.erase(0, static_cast<std::size_t>(n));
  }
}

void Grants::receive() {
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

// --- what comes ----------------------------------------------------------------------------------

void Grants::on_reply(control::Reply reply) {
  if (const auto* event = std::get_if<control::Event>(&reply.body)) return on_event(*event);
  if (reply.id == 0) {
    const auto* error = std::get_if<control::Error>(&reply.body);
    return lose(error == nullptr ? "mlccad sent a reply without a request" : error->message);
  }
  if (reply.id != asked_) return;  // of monitor, or of a delay
  if (const auto joined = control::join(whole_, std::move(reply)); !joined)
    return lose(joined.error().text);
  if (const auto* some = std::get_if<control::Transfers>(&whole_->body);
      some != nullptr && some->transfers.size() > kMostTransfers)
    return lose("mlccad sent a list without end");
  if (whole_->more) return;
  const control::Reply answer = *std::exchange(whole_, std::nullopt);
  asked_ = 0;
  retry_ = kFirstRetry;
  if (const auto* transfers = std::get_if<control::Transfers>(&answer.body)) {
    if (of_subject_)
      handlers_.of_subject(*of_subject_, transfers->transfers);
    else
      handlers_.all(transfers->transfers);
    has_answer_ = true;
  } else if (of_subject_) {
    handlers_.of_subject(*of_subject_, {});  // there is no such channel any more
  } else {
    all_due_ = true;  // it was reloaded meanwhile, or has too much to do
  }
  if (all_due_ || !due_.empty()) set_timer(kPause);
}

void Grants::on_event(const control::Event& event) {
  if (std::ranges::find(kAll, event.kind) != kAll.end())
    all_due_ = true;
  else if (event.subject != 0 && std::ranges::find(kDecisions, event.kind) != kDecisions.end())
    due_.insert(event.subject);
  else
    return;
  if (due_.size() > kMostDue) all_due_ = true;
  if (asked_ == 0) set_timer(kPause);
}

}  // namespace mlcca::relay
