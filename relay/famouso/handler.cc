// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/handler.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <span>
#include <utility>

#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

/// Connections that wait to be accepted; if the list is full, clients wait for seconds.
constexpr int kBacklog = 512;
constexpr int kMostAccepted = 4;  // connections that are accepted before other work
constexpr std::uint64_t kRefusalPause = 1'000'000'000;
constexpr std::size_t kRead = std::size_t{64} << 10U;
/// The most events of a program that are handled before events for programs here are read from the
/// kernel, which keeps some hundred.
constexpr std::size_t kAtOnce = 16;

std::string text_of(std::uint64_t subject) { return fmt::format("0x{:016x}", subject); }

std::string text_of(const sockaddr_in& address) {
  std::array<char, INET_ADDRSTRLEN> out{};
  ::inet_ntop(AF_INET, &address.sin_addr, out.data(), out.size());
  return std::string(out.data()) + ":" + std::to_string(ntohs(address.sin_port));
}

client::Options options_for(const std::string& socket) {
  client::Options out;
  out.socket = socket;
  // Do not wait for answers: they come as exceptions.
  out.patience = std::chrono::milliseconds(0);
  return out;
}

}  // namespace

Result<std::unique_ptr<EventChannelHandler>> EventChannelHandler::open(
    std::uint32_t address, std::uint16_t port, std::optional<std::set<uid_t>> users,
    const std::string& socket, Outside outside) {
  Fd listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  Fd epoll(::epoll_create1(EPOLL_CLOEXEC));
  if (!listener || !epoll) return system_error("socket");
  const int on = 1;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(address);
  at.sin_port = htons(port);
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(listener.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
      ::listen(listener.get(), kBacklog) != 0)
    return system_error("listening at " + text_of(at));
  std::unique_ptr<EventChannelHandler> out(new EventChannelHandler(
      std::move(epoll), std::move(listener), std::move(users), socket, std::move(outside)));
  if (!out->watch(out->listener_.get(), EPOLLIN, EPOLL_CTL_ADD) ||
      !out->watch(out->client_.fd(), EPOLLIN, EPOLL_CTL_ADD))
    return system_error("epoll");
  return out;
}

EventChannelHandler::EventChannelHandler(Fd epoll, Fd listener,
                                         std::optional<std::set<uid_t>> users,
                                         const std::string& socket, Outside outside)
    : epoll_(std::move(epoll)),
      listener_(std::move(listener)),
      users_(std::move(users)),
      outside_(std::move(outside)),
      client_(options_for(socket)) {}

bool EventChannelHandler::watch(int fd, std::uint32_t events, int how) const {
  epoll_event event{.events = events, .data = {.fd = fd}};
  return ::epoll_ctl(epoll_.get(), how, fd, &event) == 0;
}

std::uint16_t EventChannelHandler::port() const {
  sockaddr_in at{};
  socklen_t size = sizeof at;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  ::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&at), &size);
  return ntohs(at.sin_port);
}

void EventChannelHandler::turn(std::uint64_t now) {
  if (rests_since_ && now - *rests_since_ >= kRest) accept_again();
  std::array<epoll_event, 64> ready{};
  const int count = ::epoll_wait(epoll_.get(), ready.data(), ready.size(), 0);
  for (const epoll_event& one : std::span(ready).first(count < 0 ? 0 : count)) {
    const int fd = one.data.fd;
    if (fd == listener_.get()) {
      accept(now);
    } else if (const auto known = connections_.find(fd); known != connections_.end()) {
      if ((one.events & EPOLLOUT) != 0) write(fd, known->second);
      if ((one.events & ~std::uint32_t{EPOLLOUT}) != 0) read(fd, now);
    }
  }
  client_.process();
  if (std::exchange(is_back_, false) && std::exchange(is_away_, false))
    outside_.log("mlccad answers again");
  read_again(now);
  close_ended(now);
}

// --- connections ---------------------------------------------------------------------------------

std::optional<std::string> EventChannelHandler::refusal(const Connection& connection,
                                                        uid_t user) const {
  if (users_ && !users_->contains(user))
    return connection.name + ": it is not for programs of that user (--user)";
  if (connections_.size() >= kMostConnections)
    return connection.name + ": there are " + std::to_string(kMostConnections) + " connections";
  if (has_share(user))
    return fmt::format("{}: user {} has {} connections, the most of one user", connection.name,
                       user, kMostOfUser);
  return std::nullopt;
}

bool EventChannelHandler::has_share(uid_t user) const {
  if (user == 0) return false;
  const auto of_user = std::ranges::count_if(
      connections_, [user](const auto& one) { return one.second.user == user; });
  return static_cast<std::size_t>(of_user) >= kMostOfUser;
}

/// Logs at most one line per second, whoever connects.
void EventChannelHandler::say_counted(Counted& all, const std::string& text,
                                      std::uint64_t now) const {
  ++all.count;
  if (all.said_at != 0 && now - all.said_at < kRefusalPause) return;
  all.said_at = now;
  outside_.log(fmt::format("{} ({} so far)", text, all.count));
}

void EventChannelHandler::refuse(const std::string& whom_and_why, std::uint64_t now) {
  say_counted(refused_, "refused: " + whom_and_why, now);
}

void EventChannelHandler::make_room(uid_t user, std::uint64_t now) {
  const bool of_all = connections_.size() >= kMostConnections;
  if (!of_all && !has_share(user)) return;
  for (const auto& [fd, connection] : connections_)
    if (!connection.opened && now - connection.since >= kPatience &&
        (of_all || connection.user == user))
      ended_.emplace(fd, "it has not said what it wants, and there is no room for others");
  close_ended(now);
}

void EventChannelHandler::accept(std::uint64_t now) {
  for (int i = 0; i < kMostAccepted; ++i) {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
    Fd socket(::accept4(listener_.get(), reinterpret_cast<sockaddr*>(&from), &size,
                        SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket) {
      if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) rest(errno, now);
      return;
    }
    const auto user = outside_.user_of(socket.get());
    if (!user) {
      refuse(text_of(from) + ": whose it is is not known: " + user.error().text, now);
      continue;
    }
    Connection connection{.socket = std::move(socket),
                          .user = *user,
                          .name = text_of(from) + " of uid " + std::to_string(*user),
                          .session = {},
                          .since = now,
                          .held_since = {}};
    if (!users_ || users_->contains(*user)) make_room(*user, now);
    if (const auto why = refusal(connection, *user)) {
      refuse(*why, now);
      continue;
    }
    const int on = 1;
    const int fd = connection.socket.get();
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (watch(fd, EPOLLIN, EPOLL_CTL_ADD)) connections_.emplace(fd, std::move(connection));
  }
}

/// Stops accepting for a while: otherwise the socket would stay readable, and the loop would spin.
void EventChannelHandler::rest(int error, std::uint64_t now) {
  refuse("whoever connects: " + system_error("accept", error).error().text, now);
  rests_since_ = now;
  static_cast<void>(watch(listener_.get(), 0, EPOLL_CTL_MOD));
}

void EventChannelHandler::accept_again() {
  if (!rests_since_) return;
  rests_since_.reset();
  static_cast<void>(watch(listener_.get(), EPOLLIN, EPOLL_CTL_MOD));
}

void EventChannelHandler::read(int fd, std::uint64_t now) {
  Connection& connection = connections_.at(fd);
  std::array<std::uint8_t, kRead> octets{};
  const std::size_t missing = connection.session.missing();
  const ssize_t n = ::recv(fd, octets.data(), missing == 0 ? octets.size() : missing, MSG_DONTWAIT);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) {
    ended_.emplace(fd, "");
    return;
  }
  std::vector<LocalSession::Event> events;
  connection.session.take(std::span(octets).first(static_cast<std::size_t>(n)), events);
  if (!connection.opened) {
    open_channel(fd, connection);
    hold(fd, connection, now);
  }
  if (!events.empty()) publish(connection, events);
  if (connection.session.role() == LocalSession::Role::ended)
    ended_.emplace(fd, connection.session.why());
}

/// Stops reading from a publisher. The kernel keeps its events, and also the end of its connection.
void EventChannelHandler::hold(int fd, Connection& connection, std::uint64_t now) {
  if (connection.session.role() != LocalSession::Role::publisher) return;
  const auto known = publishers_.find(connection.session.subject());
  if (known == publishers_.end() || known->second.answered) return;
  connection.held_since = now;
  static_cast<void>(watch(fd, 0, EPOLL_CTL_DEL));
}

void EventChannelHandler::read_again(std::uint64_t now) {
  for (auto& [subject, shared] : publishers_)
    if (shared.channel->answer()->state != client::State::no_daemon) shared.answered = true;
  for (auto& [fd, connection] : connections_) {
    if (!connection.held_since) continue;
    const auto known = publishers_.find(connection.session.subject());
    if (known != publishers_.end() && !known->second.answered &&
        now - *connection.held_since < kHeld)
      continue;
    connection.held_since.reset();
    if (!watch(fd, EPOLLIN, EPOLL_CTL_ADD)) ended_.emplace(fd, "no descriptors are left");
  }
}

void EventChannelHandler::close_ended(std::uint64_t now) {
  for (const auto& [fd, why] : std::exchange(ended_, {})) close(fd, why, now);
}

void EventChannelHandler::close(int fd, const std::string& why, std::uint64_t now) {
  const auto known = connections_.find(fd);
  if (known == connections_.end()) return;
  if (!why.empty()) say_counted(closed_, known->second.name + " is closed: " + why, now);
  const std::uint64_t subject = known->second.session.subject();
  const auto leave = [&](auto& all) {
    const auto shared = all.find(subject);
    if (shared == all.end()) return;
    shared->second.connections.erase(fd);
    if (shared->second.connections.empty()) all.erase(shared);
  };
  leave(publishers_);
  leave(subscribers_);
  connections_.erase(known);
  accept_again();
}

// --- channels ------------------------------------------------------------------------------------

/// Logs it once, however many channels there are.
void EventChannelHandler::say_away(const std::string& why) {
  if (!std::exchange(is_away_, true)) outside_.log("mlccad is gone: " + why);
}

/// An answer that is not known yet comes later as an exception.
void EventChannelHandler::say_answer(std::uint64_t subject, const client::Answer& answer,
                                     std::string& said) {
  if (answer.state == client::State::no_daemon) {
    if (!client_.is_connected()) say_away(answer.reason);
    return;
  }
  std::string text = std::string(client::name_of(answer.state)) + ", " + answer.reason;
  if (text == said) return;
  said = std::move(text);
  outside_.log(text_of(subject) + ": " + said);
}

template <class ChannelOf>
void EventChannelHandler::on_exception(std::uint64_t subject, const client::Exception& exception,
                                       Shared<ChannelOf>& shared) {
  using client::Cause;
  if (exception.cause == Cause::daemon_gone) {
    say_away(exception.text);
    return;
  }
  if (exception.cause == Cause::daemon_back) {
    is_back_ = true;
    say_answer(subject, *exception.answer, shared.said);
    return;
  }
  shared.said =
      std::string(client::name_of(exception.answer->state)) + ", " + exception.answer->reason;
  outside_.log(text_of(subject) + ": " + client::name_of(exception.cause) + ": " + exception.text);
}

/// To be called when the session knows its channel. The answer may be there at once, or come later
/// as an exception.
void EventChannelHandler::open_channel(int fd, Connection& connection) {
  const auto role = connection.session.role();
  const std::uint64_t subject = connection.session.subject();
  const bool publishes = role == LocalSession::Role::publisher;
  if (!publishes && role != LocalSession::Role::subscriber) return;
  connection.opened = true;
  const std::string what =
      text_of(subject) + (publishes ? " is announced by " : " is subscribed by ") + connection.name;
  outside_.log(what);
  if (publishes) {
    auto& shared = publishers_[subject];
    shared.connections.insert(fd);
    if (shared.channel) return;
    shared.channel = std::make_unique<client::PublisherChannel>(client_, text_of(subject));
    shared.channel->on_exception(
        [this, subject, &shared](const auto& e) { on_exception(subject, e, shared); });
    say_answer(subject, *shared.channel->announce(), shared.said);
  } else {
    auto& shared = subscribers_[subject];
    shared.connections.insert(fd);
    if (shared.channel) return;
    shared.channel = std::make_unique<client::SubscriberChannel>(client_, text_of(subject));
    shared.channel->on_exception(
        [this, subject, &shared](const auto& e) { on_exception(subject, e, shared); });
    shared.channel->on_event([this, subject](const client::Event& e) { hand_out(subject, e); });
    say_answer(subject, *shared.channel->subscribe(), shared.said);
  }
}

/// Logs once when events begin to be dropped, and once when this ends.
void EventChannelHandler::publish(Connection& connection,
                                  const std::vector<LocalSession::Event>& events) {
  const std::uint64_t subject = connection.session.subject();
  const auto known = publishers_.find(subject);
  if (known == publishers_.end()) return;
  auto& shared = known->second;
  std::size_t count = 0;
  for (const auto& event : events) {
    if (count++ % kAtOnce == 0) client_.process();
    const auto how = shared.channel->publish(event.data(), event.size());
    const bool drops = how != client::Published::sent && how != client::Published::partly;
    if (drops) ++shared.dropped;
    if (drops == shared.is_dropping) continue;
    shared.is_dropping = drops;
    outside_.log(text_of(subject) +
                 (drops ? std::string(": events are dropped: ") + client::name_of(how)
                        : ": events are sent again, after " +
                              std::to_string(std::exchange(shared.dropped, 0)) + " dropped"));
  }
}

void EventChannelHandler::hand_out(std::uint64_t subject, const client::Event& event) {
  const auto known = subscribers_.find(subject);
  if (known == subscribers_.end()) return;
  for (const int fd : known->second.connections) {
    Connection& connection = connections_.at(fd);
    if (!connection.session.send({event.data, event.size}) &&
        !std::exchange(connection.loses, true))
      outside_.log(connection.name + " does not read: events of " + text_of(subject) +
                   " are lost to it");
    if (!connection.waiting) write(fd, connection);
  }
}

void EventChannelHandler::write(int fd, Connection& connection) {
  LocalSession& session = connection.session;
  while (!session.waiting().empty()) {
    const auto waiting = session.waiting();
    const ssize_t n = ::send(fd, waiting.data(), waiting.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) break;
    if (n < 0) {
      ended_.emplace(fd, "");
      return;
    }
    session.written(static_cast<std::size_t>(n));
  }
  const bool waits = !session.waiting().empty();
  if (!waits) connection.loses = false;
  if (waits == connection.waiting) return;
  connection.waiting = waits;
  static_cast<void>(watch(fd, waits ? EPOLLIN | EPOLLOUT : EPOLLIN, EPOLL_CTL_MOD));
}

}  // namespace mlcca::relay
