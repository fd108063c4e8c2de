// SPDX-License-Identifier: BSD-2-Clause
// The connection of a program to mlccad: made again whenever it is lost, monitored, never waits.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/handle.hpp"
#include "base/timer.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"

namespace mlcca::relay {

/// Of what an event says that something else may be decided than before.
enum class Affects : std::uint8_t { nothing, subject, all };
[[nodiscard]] Affects affected_by(const control::Event& event);

class DaemonLink {
 public:
  /// Handlers may send requests, and do nothing else with the link.
  struct Handlers {
    std::function<void()> connected;
    std::function<void()> lost;  ///< what was asked is not answered any more
    /// All slices of a reply together.
    std::function<void(const control::Reply&)> reply;
    std::function<void(const control::Event&)> event;
    std::function<void()> timer;  ///< see set_timer(); only while there is a connection
    std::function<void(const std::string&)> log;
  };
  /// What may wait to be sent, bytes: a daemon that does not read is asked less.
  static constexpr std::size_t kMostUnsent = std::size_t{64} << 10U;

  DaemonLink(std::string socket, Handlers handlers);

  /// The first try; handlers are called from here on.
  void start() { connect(); }
  /// Can be read when turn() has something to do: an epoll instance.
  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// Receives, sends, connects: what can be done without waiting.
  void turn();
  [[nodiscard]] bool is_connected() const { return static_cast<bool>(socket_); }
  [[nodiscard]] std::size_t unsent() const { return out_.size(); }
  /// The number of the request, which its reply has. There is a connection.
  std::uint64_t send(control::Request request);
  void flush();
  /// Calls Handlers::timer once, unless the connection is lost before. Another time takes its
  /// place.
  void set_timer(std::chrono::milliseconds time) { start_timer(timer_, time); }
  /// The daemon answers: after the next loss it is tried at once.
  void is_well() { retry_ = kFirstRetry; }

 private:
  static constexpr std::chrono::milliseconds kFirstRetry{100};

  void connect();
  void lose(const std::string& why);
  void receive();
  void on_reply(control::Reply reply);

  std::string path_;
  Handlers handlers_;
  Fd epoll_;
  Fd timer_;  ///< when to connect again, or what the user of the link wants
  Fd socket_;
  std::chrono::milliseconds retry_ = kFirstRetry;
  control::Buffer in_;
  std::string out_;
  std::uint64_t last_id_ = 0;
  std::optional<control::Reply> whole_;  ///< what has come of a reply
  std::size_t slices_ = 0;               ///< of it
  bool reported_gone_ = false;
};

}  // namespace mlcca::relay
