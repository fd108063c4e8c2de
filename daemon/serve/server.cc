// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/server.hpp"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/system_error.hpp"
#include "control/codec.hpp"
#include "control/event_kinds.hpp"
#include "daemon/serve/places.hpp"
#include "daemon/serve/session.hpp"

namespace mlcca::serve {
namespace {

constexpr std::uint64_t kSweepInterval = 5'000'000;  // µs
constexpr std::uint64_t kSweepAccuracy = 1'000'000;  // µs

bool has_hung_up(int fd) {
  pollfd socket{.fd = fd, .events = 0, .revents = 0};
  return ::poll(&socket, 1, 0) > 0 && (socket.revents & (POLLHUP | POLLERR)) != 0;
}

/// The network namespace that a socket was made in, as a number that is used once; nullopt: the
/// kernel does not say. An accepted AF_UNIX socket is in the namespace of the one that connected.
std::optional<std::uint64_t> namespace_of(int socket) {
  std::uint64_t cookie = 0;
  socklen_t size = sizeof cookie;
  if (::getsockopt(socket, SOL_SOCKET, SO_NETNS_COOKIE, &cookie, &size) != 0) return std::nullopt;
  return cookie;
}

Standing standing_of(const Peer& peer) {
  if (peer.uid == 0) return Standing::root;
  return peer.may_change ? Standing::member : Standing::other;
}

/// The kind of all withdrawals for clients that do not ask for exact kinds.
constexpr const char* kWithdrawn = "withdrawn";

/// Whether the event has one of the kinds that only clients know which ask for exact kinds.
bool is_withdrawal(const control::Event& event) {
  const auto* const kind = control::event_kind(event.kind);
  return kind != nullptr && kind->verdict == control::EventVerdict::withdrawal &&
         event.kind != kWithdrawn;
}

}  // namespace

Server::Server(sd_event* loop, Fd listening, gid_t group, AnswerTo answer)
    : loop_(loop), listening_(std::move(listening)), group_(group), answer_(std::move(answer)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::open(sd_event* loop, Fd listening, gid_t group,
                                             AnswerTo answer) {
  std::unique_ptr<Server> server(new Server(loop, std::move(listening), group, std::move(answer)));
  if (const auto added = server->add_sources(); !added) return std::unexpected(added.error());
  return server;
}

Result<void> Server::add_sources() {
  const auto on_connection = [](sd_event_source*, int, std::uint32_t, void* self) noexcept {
    auto& server = *static_cast<Server*>(self);
    const bool alone = server.turns_.empty();
    server.accept_some();
    if (alone && !server.turns_.empty()) server.take_turns();
    return 0;
  };
  const auto on_work = [](sd_event_source*, int, std::uint32_t, void* self) noexcept {
    static_cast<Server*>(self)->take_turns();
    return 0;
  };
  const auto on_time = [](sd_event_source*, std::uint64_t, void* self) noexcept {
    static_cast<Server*>(self)->take_turns();
    return 0;
  };
  const auto on_sweep = [](sd_event_source* source, std::uint64_t, void* self) noexcept {
    static_cast<Server*>(self)->sweep(monotonic_ns());
    sd_event_source_set_time_relative(source, kSweepInterval);
    sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
    return 0;
  };
  always_ = Fd(::eventfd(1, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!always_) return system_error("eventfd");
  if (const Fd own(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)); own)
    namespace_ = namespace_of(own.get());
  sd_event_source* raw = nullptr;
  int e = sd_event_add_io(loop_, &raw, listening_.get(), EPOLLIN, on_connection, this);
  source_.reset(std::exchange(raw, nullptr));
  if (e >= 0) e = sd_event_add_io(loop_, &raw, always_.get(), EPOLLIN, on_work, this);
  work_.reset(std::exchange(raw, nullptr));
  if (e >= 0) e = sd_event_source_set_enabled(work_.get(), SD_EVENT_OFF);
  if (e >= 0) e = sd_event_add_time(loop_, &raw, CLOCK_MONOTONIC, 0, 1, on_time, this);
  timer_.reset(std::exchange(raw, nullptr));
  if (e >= 0) e = sd_event_source_set_enabled(timer_.get(), SD_EVENT_OFF);
  if (e >= 0)
    e = sd_event_add_time_relative(loop_, &raw, CLOCK_MONOTONIC, kSweepInterval, kSweepAccuracy,
                                   on_sweep, this);
  sweep_.reset(std::exchange(raw, nullptr));
  if (e >= 0) return {};
  return fail(std::string("control socket: ") +
              std::strerror(-e));  // NOLINT(concurrency-mt-unsafe)
}

Result<Peer> Server::identify(int fd) const {
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &size) < 0)
    return system_error("SO_PEERCRED");
  Peer peer{.pid = who.pid, .uid = who.uid, .may_change = who.uid == 0};
  peer.process = process_of(fd, who.pid, who.gid);
  const auto its = namespace_of(fd);
  peer.is_in_other_network = namespace_ && its && *its != *namespace_;
  if (!peer.may_change && group_ != static_cast<gid_t>(-1))
    peer.may_change = peer.process->is_in(group_);
  return peer;
}

/// Makes a place for one more connection. A connection of a user that has more may be closed for
/// it.
Result<void> Server::make_place_for(const Peer& peer) {
  std::vector<Held> held;
  held.reserve(sessions_.size());
  for (const auto& [fd, s] : sessions_)
    held.push_back({fd, s->peer().uid, standing_of(s->peer()), s->use(), s->active()});
  const Admittance place = place_for(peer.uid, standing_of(peer), held);
  if (!place.refused.empty()) return fail(place.refused);
  if (place.closes)
    dismiss(place.closes->id, "closed in favour of another user: you hold " +
                                  std::to_string(place.of_its_user) + " connections");
  return {};
}

/// The budget of time limits clients that connect and leave without end: they must not fill the
/// queue of connections, nor keep connected clients from their turns.
void Server::accept_some() {
  const std::uint64_t end = monotonic_ns() + kArrivals;
  while (accept_one() && monotonic_ns() < end) {
  }
  accepted_ = monotonic_ns();
}

/// Accepts one connection. False if none waits, or none can be accepted. Without descriptors or
/// memory the socket would stay readable and the loop would never sleep, so accepting is suspended
/// until a connection ends, or until the next sweep.
bool Server::accept_one() {
  Fd socket(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  // The connection has already been closed by the client.
  if (!socket && (errno == ECONNABORTED || errno == EINTR)) return true;
  if (!socket) {
    if (errno != EAGAIN) sd_event_source_set_enabled(source_.get(), SD_EVENT_OFF);
    return false;
  }
  auto peer = identify(socket.get());
  if (!peer) return true;
  peer->session = ++last_session_;
  auto let_in = arrivals_.let_in(user_of(*peer), monotonic_ns());
  if (let_in) let_in = make_place_for(*peer);
  if (!let_in) {
    refuse(socket.get(), let_in.error().text);
    return true;
  }
  const int fd = socket.get();
  auto session = Session::open(*this, std::move(socket), *peer);
  if (!session) return true;
  Session& opened = *session;
  sessions_.emplace(fd, std::move(session));
  // Usually its request is there already, and need not wait until the loop reports it.
  if (!opened.receive())
    drop(fd);
  else if (opened.can_step())
    ready_later(opened);
  return true;
}

void Server::refuse(int fd, const std::string& why) {
  const std::string text =
      control::encode(control::Reply{0, control::Error{control::ErrorKind::world, why, {}}});
  // NOLINTNEXTLINE(bugprone-unused-return-value): the client gets the reason, if it can be sent
  (void)::send(fd, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

void Server::drop(int fd) {
  const auto it = sessions_.find(fd);
  if (it == sessions_.end()) return;
  const Peer peer = it->second->peer();
  turns_.remove(user_of(peer), fd);
  sessions_.erase(it);
  sd_event_source_set_enabled(source_.get(), SD_EVENT_ON);
  if (closed_) closed_(peer.session);
}

void Server::dismiss(int fd, const std::string& why) {
  sessions_.at(fd)->say_goodbye(why);
  drop(fd);
}

void Server::sweep(std::uint64_t now) {
  std::vector<int> idle;
  for (const auto& [fd, session] : sessions_)
    if (now > session->active() + kMostIdle && !session->is_needed()) idle.push_back(fd);
  for (const int fd : idle)
    dismiss(fd, "closed: no request came for " + std::to_string(kMostIdle / 1'000'000'000) + " s");
  turns_.tidy(now);
  sd_event_source_set_enabled(source_.get(), SD_EVENT_ON);
}

// --- turns ---------------------------------------------------------------------------------------

void Server::ready(Session& session) {
  const bool alone = turns_.empty() && !taking_turns_;
  line_up(session);
  if (alone) {
    take_turns();
    return;
  }
  session.watch();
  sd_event_source_set_enabled(work_.get(), SD_EVENT_ON);
}

void Server::ready_later(Session& session) {
  line_up(session);
  if (!taking_turns_) sd_event_source_set_enabled(work_.get(), SD_EVENT_ON);
}

void Server::line_up(Session& session) {
  if (session.in_line()) return;
  session.set_in_line(true);
  turns_.add(user_of(session.peer()), session.fd());
}

void Server::resume(std::uint64_t session) {
  for (auto& [fd, s] : sessions_)
    if (s->peer().session == session) {
      s->resume();
      if (s->can_step()) ready_later(*s);
    }
}

bool Server::is_gone(std::uint64_t session) const {
  const auto it = std::ranges::find_if(
      sessions_, [session](const auto& s) { return s.second->peer().session == session; });
  return it == sessions_.end() || has_hung_up(it->first);
}

void Server::take_turns() {
  if (monotonic_ns() - accepted_ > kArrivals) accept_some();
  taking_turns_ = true;
  const std::uint64_t begin = monotonic_ns();
  for (std::uint64_t now = begin; now < begin + kTurn; now = monotonic_ns()) {
    const auto next = turns_.next(now);
    if (!next) break;
    serve(*sessions_.at(*next), now);
  }
  taking_turns_ = false;
  wake_when_due();
}

/// Serves a session for its user's share of a turn.
void Server::serve(Session& session, std::uint64_t now) {
  session.set_in_line(false);
  // No reply is made for a client that has hung up. A request of a member may be a change, so it is
  // carried out.
  if (!session.peer().may_change && has_hung_up(session.fd())) {
    drop(session.fd());
    return;
  }
  const Turns::User user = user_of(session.peer());
  const std::uint64_t end = now + kShare;
  for (bool goes_on = session.can_step(); goes_on;) {
    session.step();
    now = monotonic_ns();
    goes_on = session.can_step() && now < end && turns_.step(user, now);
  }
  if (!session.flush()) {
    drop(session.fd());
    return;
  }
  if (session.can_step()) line_up(session);
  session.watch();
}

void Server::wake_when_due() {
  const std::uint64_t now = monotonic_ns();
  const auto due = turns_.next_ready(now);
  const bool at_once = due && *due <= now;
  sd_event_source_set_enabled(work_.get(), at_once ? SD_EVENT_ON : SD_EVENT_OFF);
  if (due && !at_once) sd_event_source_set_time(timer_.get(), *due / 1000 + 1);
  sd_event_source_set_enabled(timer_.get(), due && !at_once ? SD_EVENT_ONESHOT : SD_EVENT_OFF);
}

void Server::publish(const control::Event& event) {
  if (sessions_.empty()) return;
  const std::string exact = control::encode(control::Reply{0, event});
  std::string for_programs;
  if (is_withdrawal(event)) {
    control::Event named = event;
    named.kind = kWithdrawn;
    for_programs = control::encode(control::Reply{0, std::move(named)});
  }
  for (auto& [fd, session] : sessions_)
    if (session->wants(event))
      session->send_event(for_programs.empty() || session->wants_exact_kinds() ? exact
                                                                               : for_programs);
}

void Server::release(const Result<void>& done) {
  for (auto& [fd, session] : sessions_) session->release(done);
}

}  // namespace mlcca::serve
