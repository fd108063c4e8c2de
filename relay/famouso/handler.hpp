// SPDX-License-Identifier: BSD-2-Clause
// Lets programs that were written for FAMOUSO communicate by way of this program.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "mlcca/client/client.hpp"
#include "relay/famouso/local_protocol.hpp"

namespace mlcca::relay {

/// An event channel handler for programs that were written for FAMOUSO's own one. They connect by
/// TCP, and each connection subscribes to one channel or announces one (local_protocol.hpp). The
/// handler takes up these channels at mlccad as the user of this program, so only granted events
/// are sent or received. The protocol has no refusals: a refused channel is logged, its connection
/// stays, and its events are dropped until the channel is granted.
class EventChannelHandler {
 public:
  static constexpr std::size_t kMostConnections = 256;
  /// The most connections of one user other than root.
  static constexpr std::size_t kMostOfUser = 64;
  /// A connection that has not announced or subscribed after this time (ns) is closed if another
  /// connection needs its place. FAMOUSO's handler waits without end, and its programs may connect
  /// long before they announce.
  static constexpr std::uint64_t kPatience = 10'000'000'000;
  /// Events of a publisher are not read until mlccad has answered, but at most for this time (ns),
  /// because a program may announce, publish once and end.
  static constexpr std::uint64_t kHeld = 1'000'000'000;
  /// If descriptors or memory are lacking for a connection, accepting is tried again after this
  /// time (ns), or when another connection ends.
  static constexpr std::uint64_t kRest = 1'000'000'000;

  struct Outside {
    std::function<void(const std::string&)> log;
    /// The user of the program at the other end of a connection.
    std::function<Result<uid_t>(int socket)> user_of;
  };

  /// Listens at an IPv4 address of this host for programs of `users`, or of all users if it is
  /// nullopt. `socket` is the path of mlccad's control socket.
  static Result<std::unique_ptr<EventChannelHandler>> open(std::uint32_t address,
                                                           std::uint16_t port,
                                                           std::optional<std::set<uid_t>> users,
                                                           const std::string& socket,
                                                           Outside outside);

  /// A descriptor that is readable when turn() has something to do.
  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// To be called when fd() is readable, and at least once a second. `now` is monotonic time in ns.
  void turn(std::uint64_t now);

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] std::size_t connections() const { return connections_.size(); }
  /// The number of announced and subscribed subjects.
  [[nodiscard]] std::size_t channels() const { return publishers_.size() + subscribers_.size(); }

 private:
  struct Connection {
    Fd socket;
    uid_t user = 0;
    std::string name;  ///< for the log: "127.0.0.1:40000 of uid 1000"
    LocalSession session;
    std::uint64_t since = 0;
    bool opened = false;  ///< its channel is known
    std::optional<std::uint64_t>
        held_since;        ///< since when it is not read, because mlccad has not answered
    bool waiting = false;  ///< it waits until its socket is writable
    bool loses = false;    ///< so much waits to be written that events are lost
  };
  /// The connections of one subject and role, which share one channel.
  template <class ChannelOf>
  struct Shared {
    std::unique_ptr<ChannelOf> channel;
    std::set<int> connections;
    std::uint64_t dropped = 0;  ///< events of programs that were not sent
    bool is_dropping = false;
    bool answered = false;  ///< mlccad has answered at least once
    std::string said;       ///< the answer that was logged last
  };

  EventChannelHandler(Fd epoll, Fd listener, std::optional<std::set<uid_t>> users,
                      const std::string& socket, Outside outside);
  [[nodiscard]] bool watch(int fd, std::uint32_t events, int how) const;
  void accept(std::uint64_t now);
  void rest(int error, std::uint64_t now);
  void accept_again();
  [[nodiscard]] std::optional<std::string> refusal(const Connection& connection, uid_t user) const;
  /// Connections of which at most one per second is logged.
  struct Counted {
    std::uint64_t count = 0;
    std::uint64_t said_at = 0;
  };
  void say_counted(Counted& all, const std::string& text, std::uint64_t now) const;
  void refuse(const std::string& whom_and_why, std::uint64_t now);
  /// Closes a connection if necessary, so that a program of `user` has a place.
  void make_room(uid_t user, std::uint64_t now);
  /// Whether the user has all connections that one user may have.
  [[nodiscard]] bool has_share(uid_t user) const;
  void read(int fd, std::uint64_t now);
  void open_channel(int fd, Connection& connection);
  void hold(int fd, Connection& connection, std::uint64_t now);
  void read_again(std::uint64_t now);
  void publish(Connection& connection, const std::vector<LocalSession::Event>& events);
  void hand_out(std::uint64_t subject, const client::Event& event);
  void write(int fd, Connection& connection);
  void close(int fd, const std::string& why, std::uint64_t now);
  void close_ended(std::uint64_t now);
  void say_away(const std::string& why);
  /// Logs the answer about a channel if it has changed.
  void say_answer(std::uint64_t subject, const client::Answer& answer, std::string& said);
  template <class ChannelOf>
  void on_exception(std::uint64_t subject, const client::Exception& exception,
                    Shared<ChannelOf>& shared);

  Fd epoll_;
  Fd listener_;
  std::optional<std::set<uid_t>> users_;
  Outside outside_;
  client::Client client_;
  std::map<int, Connection> connections_;
  std::map<std::uint64_t, Shared<client::PublisherChannel>> publishers_;
  std::map<std::uint64_t, Shared<client::SubscriberChannel>> subscribers_;
  bool is_away_ = false;                      ///< the log says that mlccad is not available
  bool is_back_ = false;                      ///< a channel has an answer again since then
  std::optional<std::uint64_t> rests_since_;  ///< since when no connection can be accepted
  Counted refused_;
  Counted closed_;  ///< for a reason
  /// Descriptors to close at the end of the turn, with the reason.
  std::map<int, std::string> ended_;
};

}  // namespace mlcca::relay
