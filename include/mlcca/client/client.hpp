// SPDX-License-Identifier: BSD-2-Clause
// The application's side of a gateway: a program takes up the publishers and subscribers that the
// description has for it, learns what was decided for them and why, publishes and receives events,
// and gets an exception when what was decided changes. C++17 with the standard library. Link with
// -lmlcca (pkg-config mlcca).
//
// A Client and its channels belong to one thread. Put Client::fd() into your poll, epoll, sd-event
// or asio loop and call process() when it can be read, or call wait() in a loop of your own. Events
// go by sockets of this process and not by the daemon: the gate sees which user sends them. After
// fork() only one of both processes may go on using it. Before version 1.0 each minor version has
// an ABI of its own, and the name of the library says which.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mlcca/attribute.hpp"
#include "mlcca/values_of.hpp"

#define MLCCA_API __attribute__((visibility("default")))

struct mlcca_events;  // mlcca/client/events.h

namespace mlcca::client {

/// One attribute, held against one place on the way of an event.
struct Check {
  std::string where;              ///< network or gateway, "end to end", "publisher NAME", …
  std::string attribute;          ///< "Omission"
  std::string unit;               ///< of both values: "ns", "bytes/s", "1e-9", "events", "bytes"
  Value required = 0;             ///< what publisher and subscribers ask for together
  std::optional<Value> provided;  ///< nothing: it is not known
  bool fits = false;
  std::string margin;  ///< readable: "1 to spare", "3 events too many"
};

/// What was decided for the events of one publisher towards one network or gateway.
struct Delivery {
  bool granted = false;
  std::string publisher;
  std::string from;
  std::string to;
  std::string reason;   ///< one line: the smallest margin, or why it is refused
  unsigned set = 0;     ///< attribute set in use, 0: the preferred one
  std::string trouble;  ///< what is wrong although it is granted; empty: nothing
  std::vector<std::string> route;
  std::vector<Check> checks;
};

enum class State : std::uint8_t {
  unannounced,
  granted,    ///< every delivery
  partly,     ///< some deliveries are granted, some refused
  refused,    ///< every delivery, or there is none
  rejected,   ///< the daemon does not take the announcement: see the reason
  no_daemon,  ///< nothing is known while no daemon answers
};

/// What is known of a channel.
struct Answer {
  State state = State::unannounced;
  /// One line: of a delivery that is refused, else of the one that is granted; or the error.
  std::string reason;
  std::vector<Delivery> deliveries;
};

/// Why an exception handler is called.
enum class Cause : std::uint8_t {
  granted,       ///< a delivery that was refused is granted
  refused,       ///< a delivery is refused
  withdrawn,     ///< a delivery was granted and is not any more
  network_down,  ///< the same, since a network on its way is not available: see `network`
  rejected,      ///< after a reload the announcement does not go with the description any more
  degraded,      ///< another attribute set is in use, which asks for less
  upgraded,      ///< another attribute set is in use, which gives more
  policed,       ///< the publisher sent more than was admitted
  dropped,       ///< the gate dropped frames of the channel
  missing,       ///< nothing has come for longer than a subscriber's Omission allows
  restored,      ///< events come again
  missed,        ///< events of programs on this gateway were lost, since they were not read in time
  late,          ///< events took longer in mlcca-relay than the gateway states
  gates_closed,  ///< the kernel closed all gates for a while, or the daemon ends and closes them
  mode,          ///< enforce or audit
  lagged,        ///< exceptions were lost: this program called process() too seldom
  daemon_gone,   ///< nothing is known any more; granted deliveries hold for the grace period
  daemon_back,   ///< it is announced again: see the answer
  other,         ///< of a newer daemon: see the text
};
/// "withdrawn"
MLCCA_API const char* name_of(Cause cause);
MLCCA_API const char* name_of(State state);

struct Exception {
  Cause cause = Cause::other;
  std::string text;                   ///< one line, as in the log of the gateway
  std::string publisher;              ///< that it is of, by its name; empty: of several, or of none
  std::string network;                ///< network_down: which one
  std::chrono::nanoseconds silent{};  ///< missing, restored: how long nothing came
  std::uint64_t missing_events = 0;   ///< missing, restored: how many did not come in that time;
                                      ///< missed: so many since the last such exception
  std::uint64_t frames = 0;           ///< policed, dropped: so many since the last such exception
  std::uint64_t late_events = 0;      ///< late: so many since the last such exception
  std::chrono::nanoseconds longest{};    ///< late: the time that one of these took in mlcca-relay
  std::shared_ptr<const Answer> answer;  ///< what is decided now
};

/// An event that has come.
struct Event {
  const std::uint8_t* data = nullptr;  ///< valid as long as the handler runs
  std::size_t size = 0;                ///< bytes, 0 to 65,535
  const char* network = "";            ///< that it came from; empty: from a program on the gateway
  /// When the kernel received it, or, of a program on the gateway, when it was read.
  std::chrono::system_clock::time_point received;
};

/// What became of an event that was published.
enum class Published : std::uint8_t {
  sent,         ///< to every place that it is granted for
  partly,       ///< to some of them; the others have a full queue, or their gate drops it
  lost,         ///< to none of them
  not_granted,  ///< nothing is granted, or nothing is known yet, so that it was not sent
  too_long,     ///< longer than a network carries
};
MLCCA_API const char* name_of(Published published);

struct Options {
  std::string socket = "/run/mlcca/control.sock";
  /// How long announce() and subscribe() wait for an answer; less than 0: without end.
  std::chrono::milliseconds patience{10'000};
  /// How long after the daemon is lost it is tried again: this, then twice as long, up to
  /// `longest`.
  std::chrono::milliseconds first_retry{100};
  std::chrono::milliseconds longest_retry{5'000};
};

class Channel;

/// A connection to mlccad, which is made when it is needed and made again when it is lost.
class MLCCA_API Client {
 public:
  /// Throws std::system_error when the process has no file descriptors left. No daemon is needed.
  explicit Client(Options options = {});
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  Client(Client&&) = delete;
  Client& operator=(Client&&) = delete;
  ~Client();

  /// Can be read when there is something for process() to do. It stays the same.
  [[nodiscard]] int fd() const;
  /// Does what there is to do and calls exception handlers. Never waits. What a handler throws
  /// comes out of here; the other exceptions are kept for the next call.
  void process();
  /// process(), after waiting until there is something to do, for at most so long. A negative time
  /// is without end.
  void wait(std::chrono::milliseconds time);
  [[nodiscard]] bool is_connected() const;

 private:
  friend class Channel;
  friend struct ::mlcca_events;
  class __attribute__((visibility("hidden"))) Connection;
  class __attribute__((visibility("hidden"))) Data;
  std::shared_ptr<Connection> connection_;
};

/// What a publisher and a subscriber have in common. A channel may outlive its Client; then nothing
/// happens to it any more.
class MLCCA_API Channel {
 public:
  using Handler = std::function<void(const Exception&)>;

  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  Channel(Channel&&) = delete;
  Channel& operator=(Channel&&) = delete;

  /// Called by Client::process(), never by announce() or subscribe(). The channel may be destroyed
  /// in it.
  void on_exception(Handler handler);
  /// What is known now.
  [[nodiscard]] std::shared_ptr<const Answer> answer() const;

 protected:
  enum class Role : std::uint8_t { publisher, subscriber };
  Channel(Client& client, Role role, std::string channel, const AttributeSet& stated,
          std::string name);
  ~Channel();
  std::shared_ptr<const Answer> take_up();
  Published send(const void* data, std::size_t size);
  void receive(std::function<void(const Event&)> handler);
  [[nodiscard]] std::uint64_t losses() const;

 private:
  friend class Client;
  friend struct ::mlcca_events;
  struct __attribute__((visibility("hidden"))) Part;
  std::shared_ptr<Part> part_;
};

class MLCCA_API PublisherChannel : public Channel {
 public:
  /// `channel`: its name, or its subject as "0xa4efeccc3210b497". `stated`: what this program was
  /// made with, so that it is refused where the description has less; values_of<Spec::attributes>()
  /// of a specification. `name`: of the publisher in the description, where several are for the
  /// user that runs this program.
  PublisherChannel(Client& client, std::string channel, const AttributeSet& stated = {},
                   std::string name = {})
      : Channel(client, Role::publisher, std::move(channel), stated, std::move(name)) {}

  /// Takes the publisher up and waits for the answer, at most Options::patience. Whatever it is,
  /// the channel is announced again by itself whenever a daemon is there, until it is destroyed.
  std::shared_ptr<const Answer> announce() { return take_up(); }

  /// Sends an event to every network that the channel is granted for, and to subscribers on this
  /// gateway. Never waits. While the daemon is gone it goes on where it was granted, until the gate
  /// closes after the grace period.
  Published publish(const void* data, std::size_t size) { return send(data, size); }
  Published publish(const std::string& text) { return send(text.data(), text.size()); }
};

class MLCCA_API SubscriberChannel : public Channel {
 public:
  /// As for a publisher.
  SubscriberChannel(Client& client, std::string channel, const AttributeSet& stated = {},
                    std::string name = {})
      : Channel(client, Role::subscriber, std::move(channel), stated, std::move(name)) {}

  /// As PublisherChannel::announce().
  std::shared_ptr<const Answer> subscribe() { return take_up(); }

  using EventHandler = std::function<void(const Event&)>;
  /// Called by Client::process() for each event, in the order in which they came from a network.
  /// The channel may be destroyed in it.
  void on_event(EventHandler handler) { receive(std::move(handler)); }
  /// Frames and events that came from networks to any channel of this Client and were not whole,
  /// malformed, or lost in a socket of this process, since it was made. Of programs on the gateway
  /// itself those that are longer than the channel's MaxPayload or more than is admitted, and those
  /// that were missed.
  [[nodiscard]] std::uint64_t lost() const { return losses(); }
};

}  // namespace mlcca::client
