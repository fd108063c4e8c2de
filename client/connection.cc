// SPDX-License-Identifier: BSD-2-Clause
#include "client/connection.hpp"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <system_error>
#include <utility>
#include <variant>

#include "base/timer.hpp"
#include "base/unix_address.hpp"
#include "client/answers.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"
#include "control/utf8.hpp"

namespace mlcca::client {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kReadSize = std::size_t{64} << 10;
/// Bytes received in one turn, so that a daemon that sends without pause does not block the
/// program.
constexpr std::size_t kMostOfTurn = std::size_t{1} << 20;
/// Deliveries accepted in one answer; more than a gateway can have of one channel.
constexpr std::size_t kMostRows = std::size_t{1} << 18;
/// The longest wait. It fits poll(2) and does not overflow the clock.
constexpr milliseconds kLongest(std::chrono::hours(24));

/// What cannot be used, such as a port that another program holds, is tried again after so many
/// times the longest delay of a connection.
constexpr int kLonger = 5;
/// How many pings fit into the time within which the daemon must answer.
constexpr int kPingsOfTime = 5;

/// Shortens a delay by up to a quarter at random.
milliseconds shortened(milliseconds delay) {
  std::uint32_t random = 0;
  if (::getrandom(&random, sizeof random, GRND_NONBLOCK) != sizeof random) return delay;
  const milliseconds by = delay / 4 * (random % 1024) / 1024;
  return std::max(delay - by, milliseconds(1));
}

std::string text_of(int error) { return std::strerror(error); }  // NOLINT(concurrency-mt-unsafe)

bool add_to(const Fd& epoll, const Fd& fd, std::uint32_t events) {
  epoll_event event{.events = events, .data = {.fd = fd.get()}};
  return ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd.get(), &event) == 0;
}

int for_poll(milliseconds time) {
  return time.count() < 0 ? -1 : static_cast<int>(std::min(time, kLongest).count());
}

/// Why the request cannot be sent: the daemon would close the connection, and with it all channels.
/// Null: it can be sent.
const char* why_not_sent(const control::AnnounceRequest& request, std::size_t size) {
  constexpr std::size_t length = 3;  // of the varint for bodies of 16 KiB and more
  if (size > control::Request::kMaxBytes + length)
    return "the names and attributes are longer than a request may be, 65,536 bytes";
  if (!control::is_utf8(request.channel) || !control::is_utf8(request.name))
    return "the names are not UTF-8";
  return nullptr;
}

std::shared_ptr<const Answer> no_daemon(const std::string& why) {
  return std::make_shared<Answer>(
      Answer{.state = State::no_daemon, .reason = why, .deliveries = {}});
}

}  // namespace

Client::Connection::Connection(Options options)
    : options_(std::move(options)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      supervision_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      noticed_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!epoll_ || !timer_ || !supervision_ || !noticed_ || !add_to(epoll_, timer_, EPOLLIN) ||
      !add_to(epoll_, supervision_, EPOLLIN) || !add_to(epoll_, noticed_, EPOLLIN))
    throw std::system_error(errno, std::system_category(), "a connection to mlccad");
  options_.first_retry = std::clamp(options_.first_retry, milliseconds(1), kLongest);
  options_.longest_retry = std::clamp(options_.longest_retry, options_.first_retry, kLongest);
  options_.answers_within = std::min(options_.answers_within, kLongest);
  retry_ = options_.first_retry;
}

// --- made and lost -------------------------------------------------------------------------------

void Client::Connection::connect(Try why) {
  if (socket_) return;
  const auto address = unix_address(options_.socket);
  if (!address) {
    lose(address.error().text, why);
    return;
  }
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket || ::connect(socket.get(), generic(*address), sizeof *address) != 0 ||
      !add_to(epoll_, socket, EPOLLIN)) {
    lose("no daemon: " + options_.socket + ": " + text_of(errno), why);
    return;
  }
  socket_ = std::move(socket);
  start_timer(timer_, milliseconds(0));
  received_ = Clock::now();
  supervise();
  for (const PartOf& part : parts()) ask(part);
  flush();
}

void Client::Connection::retry_later(Try after) {
  start_timer(timer_, shortened(retry_));
  if (after == Try::planned) retry_ = std::min(retry_ * 2, options_.longest_retry);
}

/// Closes the connection, discards what was pending, and tries again after the delay.
void Client::Connection::lose(const std::string& why, Try after) {
  socket_.reset();
  in_ = control::Buffer();
  out_.clear();
  asked_.clear();
  retry_later(after);
  start_timer(supervision_, milliseconds(0));
  ping_ = 0;
  hangs_ = stops_ = false;
  for (const PartOf& part : parts()) {
    part->asked = 0;
    part->outdated = part->failed = false;
  }
  note_gone(why, Clock::now());
}

void Client::Connection::note_gone(const std::string& why, Clock::time_point since) {
  for (const PartOf& part : parts()) {
    data_.lose_daemon(part, static_cast<std::uint64_t>(
                                std::chrono::nanoseconds(since.time_since_epoch()).count()));
    const State before = part->answer.state();
    part->lost = true;
    part->answer = KeptAnswer(no_daemon(why));
    if (before == State::no_daemon || before == State::unannounced) continue;
    part->note(Cause::daemon_gone, why);
  }
}

// --- a daemon that hangs -------------------------------------------------------------------------

/// Octets have come from the daemon. If it had hung, the decisions may have changed.
void Client::Connection::note_received() {
  received_ = Clock::now();
  if (!std::exchange(hangs_, false)) return;
  for (const PartOf& part : parts()) ask_again(part);
  supervise();
}

/// Asks the daemon if it was silent for a while, and gives it up if it does not answer. The
/// connection stays, and no further ping is sent: the daemon answers when it runs again. Everything
/// that has come must have been received, because this program may have slept itself.
void Client::Connection::supervise() {
  if (!socket_ || !is_supervised() || !knows_pings_ || hangs_) return;
  const auto now = Clock::now();
  const auto pause = std::max(options_.answers_within / kPingsOfTime, milliseconds(1));
  if (ping_ == 0 && now - received_ >= pause) {
    ping_ = ++last_id_;
    pinged_ = now;
    out_ += control::encode(control::Request{ping_, control::PingRequest{}, false});
  }
  const auto silent_since = ping_ == 0 ? received_ : std::max(received_, pinged_);
  const auto due = silent_since + (ping_ == 0 ? pause : options_.answers_within);
  if (ping_ != 0 && now >= due) {
    hangs_ = true;
    note_gone("mlccad does not answer: nothing has come from it for " +
                  std::to_string(options_.answers_within.count()) + " ms",
              received_);
    return;
  }
  start_timer(supervision_, std::chrono::ceil<milliseconds>(due - now));
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
    connect(Try::asked_for);
  else
    ask_again(part);
  const bool for_ever = options_.patience.count() < 0;
  const auto end = Clock::now() + std::min(options_.patience, kLongest);
  for (turn(); part->asked != 0; turn()) {
    const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
    if (!for_ever && left.count() <= 0) break;
    wait_for_daemon(for_ever ? milliseconds(-1) : left);
  }
  if (part->asked == 0) return;
  part->lost = true;  // so that an answer that comes later is reported
  part->answer = KeptAnswer(no_daemon("no answer from mlccad within " +
                                      std::to_string(options_.patience.count()) + " ms"));
}

void Client::Connection::ask(const PartOf& part) {
  if (part->request.role == control::Role::subscriber) part->request.local = data_.address(part);
  part->outdated = part->failed = false;
  const std::string request = control::encode(control::Request{last_id_ + 1, part->request, true});
  if (const char* wrong = why_not_sent(part->request, request.size())) {
    part->asked = 0;
    part->take(std::make_shared<Answer>(
        Answer{.state = State::rejected, .reason = wrong, .deliveries = {}}));
    return;
  }
  part->asked = ++last_id_;
  asked_.emplace(part->asked, PendingRequest{part});
  out_ += request;
}

void Client::Connection::ask_again(const PartOf& part) {
  if (part->asked == 0)
    ask(part);
  else
    part->outdated = true;
}

/// Makes the client's descriptor readable, since something waits for handlers.
void Client::Connection::wake() {
  const std::uint64_t one = 1;
  static_cast<void>(::write(noticed_.get(), &one, sizeof one) < 0);
}

// --- bytes ---------------------------------------------------------------------------------------

void Client::Connection::turn() {
  std::uint64_t expired = 0;
  const bool due = ::read(timer_.get(), &expired, sizeof expired) == sizeof expired;
  if (!socket_ && due) connect(Try::planned);
  if (socket_ && due)
    for (const PartOf& part : parts())
      if (part->failed) ask(part);
  const bool is_to_supervise =
      ::read(supervision_.get(), &expired, sizeof expired) == sizeof expired;
  if (socket_) flush();
  if (socket_) receive();
  if (socket_ && is_to_supervise) supervise();
  if (socket_) flush();
  if (has_exceptions()) wake();
}

void Client::Connection::receive() {
  for (std::size_t received = 0; socket_ && received < kMostOfTurn;) {
    const auto room = in_.space(kReadSize);
    const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return;
    if (n > 0) {
      received += static_cast<std::size_t>(n);
      in_.commit(static_cast<std::size_t>(n));
      note_received();
      take_replies();
    } else {
      lose(n == 0 ? "mlccad closed the connection" : text_of(errno));
    }
  }
}

/// Handles the complete replies in the buffer.
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
    if (n >= 0) {
      out_.erase(0, static_cast<std::size_t>(n));
      continue;
    }
    // Read what the daemon has sent before it closed; then recv() reports the end of the
    // connection.
    out_.clear();
    ::shutdown(socket_.get(), SHUT_RDWR);
  }
  watch();
}

void Client::Connection::watch() {
  epoll_event event{.events = EPOLLIN | (out_.empty() ? 0U : EPOLLOUT),
                    .data = {.fd = socket_.get()}};
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, socket_.get(), &event);
}

/// Receiving an event takes no more system calls than needed: turn() is called only if a descriptor
/// of the connection is ready.
void Client::Connection::run(milliseconds time) {
  std::array<epoll_event, 16> ready{};
  const int count = ::epoll_wait(epoll_.get(), ready.data(), ready.size(),
                                 data_.has_waiting() ? 0 : for_poll(time));
  const auto all = std::span(ready).first(count < 0 ? 0 : count);
  // What the daemon says comes first: it may have ended what is granted. If the array is full, it
  // may be among what is left.
  const bool is_full = all.size() == ready.size();
  const bool other =
      is_full || std::ranges::any_of(all, [&](const auto& one) { return is_own(one.data.fd); });
  if (other) turn();
  for (const epoll_event& one : all)
    if (!is_own(one.data.fd)) static_cast<void>(data_.receive(one.data.fd));
  const auto happened = data_.take_happened();
  for (const auto& [part, event] : happened) on_happened(part, event);
  if (!happened.empty()) wake();
  try {
    data_.call_handlers();
  } catch (...) {
    if (data_.has_waiting()) wake();
    throw;
  }
  if (other || !happened.empty()) call_exception_handlers();
}

/// Waits for the daemon's socket alone, even if handlers have work to do.
void Client::Connection::wait_for_daemon(milliseconds time) const {
  const auto events = static_cast<short>(POLLIN | (out_.empty() ? 0 : POLLOUT));
  pollfd waits{.fd = socket_.get(), .events = events, .revents = 0};
  ::poll(&waits, 1, for_poll(time));
}

// --- what comes ----------------------------------------------------------------------------------

void Client::Connection::on_reply(control::Reply reply) {
  if (const auto* event = std::get_if<control::Event>(&reply.body)) {
    on_event(*event);
    return;
  }
  if (ping_ != 0 && reply.id == ping_) {
    ping_ = 0;
    return;
  }
  if (reply.id == 0) {
    if (ping_ != 0) knows_pings_ = false;
    const auto* error = std::get_if<control::Error>(&reply.body);
    lose(error == nullptr ? "mlccad sent a reply without a request" : error->message);
    return;
  }
  const auto found = asked_.find(reply.id);
  if (found == asked_.end()) return;
  if (const auto* channels = std::get_if<control::Channels>(&reply.body))
    found->second.rows += channels->channels.size();
  if (found->second.rows > kMostRows) {
    lose("mlccad sent an answer without end");
    return;
  }
  if (const auto joined = control::join(found->second.whole, std::move(reply)); !joined) {
    lose(joined.error().text);
    return;
  }
  if (found->second.whole->more) return;
  const PendingRequest asked = std::move(found->second);
  asked_.erase(found);
  retry_ = options_.first_retry;
  if (const PartOf part = asked.part.lock()) on_answer(part, *asked.whole);
}

void Client::Connection::on_answer(const PartOf& part, const control::Reply& reply) {
  part->asked = 0;
  auto answer = answer_of(reply);
  if (!answer) {
    // A temporary error, e.g. overload or lack of memory. The last known answer stays.
    part->failed = true;
    retry_later(Try::asked_for);
    if (part->answer.state() != State::unannounced && part->answer.state() != State::no_daemon)
      return;
    const auto* error = std::get_if<control::Error>(&reply.body);
    part->answer = KeptAnswer(
        no_daemon(error == nullptr ? "mlccad answered with something else" : error->message));
    part->lost = true;
    return;
  }
  carry(part, reply);
  // Something has happened since this request was sent, so only the next answer is certain to
  // include it.
  if (part->outdated) {
    ask(part);
    return;
  }
  part->take(std::make_shared<Answer>(std::move(*answer)));
  if (std::exchange(part->lost, false)) part->note(Cause::daemon_back, part->answer.get()->reason);
}

/// Applies the endpoints of an answer. If that fails it is tried again later, because e.g. another
/// program may hold a port for a while. If the address for programs on the gateway has changed, the
/// channel is announced again, so that the daemon learns it.
void Client::Connection::carry(const PartOf& part, const control::Reply& reply) {
  const auto done = data_.use(part, reply);
  if (stops_) data_.close_local(part);
  const std::string problem = done ? "" : done.error().text;
  if (part->local && part->request.local != part->local->address() &&
      std::holds_alternative<control::Channels>(reply.body))
    part->outdated = true;
  if (!done) {
    part->failed = true;
    start_timer(timer_, kLonger * options_.longest_retry);
  }
  if (part->problem == problem) return;
  part->problem = problem;
  part->note(Cause::other,
             done ? "its events can be carried again" : "its events cannot be carried: " + problem);
}

void Client::Connection::on_event(const control::Event& event) {
  if (event.kind == "stopped") {
    stops_ = true;
    for (const PartOf& part : parts()) data_.close_local(part);
  }
  const Meaning meaning = meaning_of(event);
  const auto is_of = [&event](const Channel::Part& part) {
    // Without a delivery only the channel's name is known.
    return event.subject == 0 || event.subject == part.subject ||
           event.channel == part.request.channel;
  };
  for (const PartOf& part : parts())
    if (is_of(*part)) on_event(part, event, meaning);
}

void Client::Connection::on_event(const PartOf& part, const control::Event& event,
                                  Meaning meaning) {
  // An event before the first answer happened before the channel was announced.
  if (meaning == Meaning::happened && part->answer.state() == State::unannounced) return;
  if (const auto cause = said_further_on(event)) {
    if (part->request.role == control::Role::subscriber) part->note(*cause, event.message, &event);
  } else if (meaning == Meaning::happened) {
    if (event.subject == 0 || part->concerns(event)) on_happened(part, event);
  } else {
    if (meaning == Meaning::withdrawn) withdraw(part, event);
    ask_again(part);
  }
}

/// No gate is between programs on the gateway, so the library ends their events before the daemon
/// answers: it may be unable to.
void Client::Connection::withdraw(const PartOf& part, const control::Event& event) {
  const bool had_local = part->is_granted_here();
  part->withdraw(event);
  if (had_local && !part->is_granted_here()) data_.close_local(part);
}

void Client::Connection::on_happened(const PartOf& part, const control::Event& event) {
  const Cause cause = cause_of(event);
  const bool is_outdated = cause == Cause::restored && part->forget_problem(event);
  part->note(cause, event.message, &event);
  if (is_outdated) ask_again(part);  // the delivery may have other problems
}

bool Client::Connection::has_exceptions() {
  return std::ranges::any_of(
      parts(), [](const PartOf& part) { return !part->waiting.empty() || part->lagged; });
}

void Client::Connection::call_exception_handlers() {
  for (const PartOf& part : parts()) {
    // Exceptions that are added while a handler runs wait for the next turn.
    for (std::size_t left = part->waiting.size() + (part->lagged ? 1 : 0); left != 0; --left) {
      const auto exception = part->next();
      const auto handler = part->handler;  // a copy: the handler may replace it
      if (exception && handler) (*handler)(*exception);
      if (part.use_count() == 1) break;  // the handler has destroyed its channel
    }
  }
  // Not reached if a handler throws: the eventfd stays readable, and the rest is handled in the
  // next turn.
  std::uint64_t count = 0;
  static_cast<void>(::read(noticed_.get(), &count, sizeof count) < 0);
  if (has_exceptions()) wake();
}

}  // namespace mlcca::client
