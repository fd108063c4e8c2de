// SPDX-License-Identifier: BSD-2-Clause
// An event channel handler for programs that were written for FAMOUSO's: they connect by TCP, and
// subscribe or announce one channel each (local_protocol.hpp). Their channels are taken up at
// mlccad as those of this program's user, so that nothing goes or comes that is not granted to it.
//
// The protocol has no refusals: what is refused is logged, the connection stays, and its events are
// dropped until the channel is granted.
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

class EventChannelHandler {
 public:
  static constexpr std::size_t kMostConnections = 256;
  /// Of one user other than root.
  static constexpr std::size_t kMostOfUser = 64;
  /// A connection that has not said for so long what it wants is closed when there is no room for
  /// another one, ns. FAMOUSO's handler waits without end, and its programs may connect long before
  /// they announce.
  static constexpr std::uint64_t kPatience = 10'000'000'000;
  /// What a publisher sends is not read before mlccad has answered, or for so long, ns: a program
  /// may announce, publish once and end.
  static constexpr std::uint64_t kHeld = 1'000'000'000;
  /// Where descriptors or memory are lacking for a connection, it is tried again after this time,
  /// or when another one ends, ns.
  static constexpr std::uint64_t kRest = 1'000'000'000;

  struct Outside {
    std::function<void(const std::string&)> log;
    /// Of the program at the other end of a connection.
    std::function<Result<uid_t>(int socket)> user_of;
  };

  /// Listens at an IPv4 address of this host, for programs of these users; without any: of all.
  /// `socket`: the control socket of mlccad.
  static Result<std::unique_ptr<EventChannelHandler>> open(std::uint32_t address,
                                                           std::uint16_t port,
                                                           std::optional<std::set<uid_t>> users,
                                                           const std::string& socket,
                                                           Outside outside);

  /// Can be read when there is something for turn() to do.
  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// Call it once a second in any case. `now`: monotonic, ns.
  void turn(std::uint64_t now);

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] std::size_t connections() const { return connections_.size(); }
  /// Subjects with an announcement or a subscription.
  [[nodiscard]] std::size_t channels() const { return publishers_.size() + subscribers_.size(); }

 private:
  struct Connection {
    Fd socket;
    uid_t user = 0;
    std::string name;  ///< "127.0.0.1:40000 of uid 1000"
    LocalSession session;
    std::uint64_t since = 0;
    bool opened = false;                      ///< its channel is known
    std::optional<std::uint64_t> held_since;  ///< not read: mlccad has not answered yet
    bool waiting = false;                     ///< for room to write
    bool loses = false;                       ///< so much waits that events are lost
  };
  /// All connections of a subject have one channel of each role.
  template <class ChannelOf>
  struct Shared {
    std::unique_ptr<ChannelOf> channel;
    std::set<int> connections;
    std::uint64_t dropped = 0;  ///< events of programs that were not sent
    bool is_dropping = false;
    bool answered = false;  ///< once
    std::string said;       ///< what was answered last
  };

  EventChannelHandler(Fd epoll, Fd listener, std::optional<std::set<uid_t>> users,
                      const std::string& socket, Outside outside);
  [[nodiscard]] bool watch(int fd, std::uint32_t events, int how) const;
  void accept(std::uint64_t now);
  void rest(int error, std::uint64_t now);
  void accept_again();
  [[nodiscard]] std::optional<std::string> refusal(const Connection& connection, uid_t user) const;
  void refuse(const std::string& whom_and_why, std::uint64_t now);
  /// So that a program of the user has a place.
  void make_room(uid_t user, std::uint64_t now);
  /// No more of this user, however many others there are.
  [[nodiscard]] bool has_share(uid_t user) const;
  void read(int fd, std::uint64_t now);
  void open_channel(int fd, Connection& connection);
  void hold(int fd, Connection& connection, std::uint64_t now);
  void read_again(std::uint64_t now);
  void publish(Connection& connection, const std::vector<LocalSession::Event>& events);
  void hand_out(std::uint64_t subject, const client::Event& event);
  void write(int fd, Connection& connection);
  void close(int fd, const std::string& why);
  void close_ended();
  void say_away(const std::string& why);
  /// Of the channel, unless it is as it was.
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
  bool is_away_ = false;                      ///< mlccad, as it was said
  bool is_back_ = false;                      ///< a channel has its answer again
  std::optional<std::uint64_t> rests_since_;  ///< no connection can be taken
  std::uint64_t refused_ = 0;
  std::uint64_t refused_at_ = 0;      ///< when that was said
  std::map<int, std::string> ended_;  ///< to be closed at the end of a turn, and why
};

}  // namespace mlcca::relay
