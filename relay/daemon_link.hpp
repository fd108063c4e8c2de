// SPDX-License-Identifier: BSD-2-Clause
// A connection of a program of the relay to mlccad.
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

/// What has to be asked again because of an event of the daemon: nothing, the event's subject, or
/// everything.
enum class Affects : std::uint8_t { nothing, subject, all };
[[nodiscard]] Affects affected_by(const control::Event& event);

/// A connection to mlccad with its event monitor. It is made again whenever it is lost, and never
/// waits.
class DaemonLink {
 public:
  /// Handlers may send requests; they must not call anything else of the link.
  struct Handlers {
    std::function<void()> connected;
    std::function<void()> lost;  ///< pending requests will not be answered
    /// Called with a complete reply, whose slices are joined.
    std::function<void(const control::Reply&)> reply;
    std::function<void(const control::Event&)> event;
    std::function<void()> timer;  ///< see set_timer(); called only while connected
    std::function<void(const std::string&)> log;
  };
  /// Bytes that may wait for sending; while there are more, a daemon that does not read is asked
  /// less.
  static constexpr std::size_t kMostUnsent = std::size_t{64} << 10U;

  DaemonLink(std::string socket, Handlers handlers);

  /// Tries to connect for the first time. Handlers are called from here on.
  void start() { connect(); }
  /// An epoll descriptor that is readable when turn() has work to do.
  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// Receives, sends and connects as far as that is possible without waiting.
  void turn();
  [[nodiscard]] bool is_connected() const { return static_cast<bool>(socket_); }
  [[nodiscard]] std::size_t unsent() const { return out_.size(); }
  /// Sends a request and returns its id, which the reply has as well. Only while connected.
  std::uint64_t send(control::Request request);
  void flush();
  /// Calls Handlers::timer once after this time, unless the connection is lost before. A further
  /// call replaces the time.
  void set_timer(std::chrono::milliseconds time) { start_timer(timer_, time); }
  /// Resets the delay before reconnecting, because the daemon answers.
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
  Fd timer_;  ///< time to connect again, or the time of set_timer()
  Fd socket_;
  std::chrono::milliseconds retry_ = kFirstRetry;
  control::Buffer in_;
  std::string out_;
  std::uint64_t last_id_ = 0;
  std::optional<control::Reply> whole_;  ///< slices of a reply received so far, joined
  std::size_t slices_ = 0;               ///< number of these slices
  bool reported_gone_ = false;
};

}  // namespace mlcca::relay
