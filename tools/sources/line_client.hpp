// SPDX-License-Identifier: BSD-2-Clause
// A stream to a local server that speaks in lines: connects without blocking the loop, again and
// again.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/net/sources/timer.hpp"
#include "tools/sources/endpoint.hpp"
#include "tools/sources/peer.hpp"

namespace mlcca::net {

class LineClient {
 public:
  /// Longest line; a server that sends a longer one is not the one we mean.
  static constexpr std::size_t kLongestLine = std::size_t{64} << 10;
  /// Bytes of one answer; and of what is read in one turn of the loop.
  static constexpr std::size_t kLongestAnswer = std::size_t{4} << 20;
  static constexpr std::size_t kTurn = std::size_t{16} << 10;

  struct Handlers {
    std::function<void()> connected;
    /// Without its end of line. What comes after the last one is a line too, when the server
    /// closes.
    std::function<void(std::string_view)> line;
    /// The connection is over, or did not come about. Empty: the server has closed it.
    std::function<void(const std::string& why)> ended;
  };

  /// `pause`: µs between the end of a connection and the next attempt. `patience`: µs in which an
  /// answer must be complete, from the beginning or from the one before. Connects in the first turn
  /// of the loop; handlers are called from the loop, and none of them may destroy the client.
  LineClient(Endpoint endpoint, std::uint64_t pause, std::uint64_t patience, Handlers handlers);

  [[nodiscard]] Result<void> start(sd_event* loop);
  /// Requests are short and few: one that the socket does not take whole ends the connection.
  void send(std::string_view request);
  /// An answer is complete: time and bytes are counted from 0 again.
  void complete();
  /// Ends the connection as if the server had; the next attempt comes after the pause.
  void end(const std::string& why);

 private:
  static int on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept;
  void connect();
  Result<void> begin_connecting();
  [[nodiscard]] Result<void> check_server() const;
  void receive();
  /// False: a handler has ended the connection.
  bool take_lines();
  void on_time();

  Endpoint endpoint_;
  Listeners listeners_;  ///< before the connection
  std::uint64_t pause_;
  std::uint64_t patience_;
  Handlers handlers_;
  sd_event* loop_ = nullptr;
  Fd socket_;
  EventSource io_;
  Timer timer_;
  bool connected_ = false;
  std::size_t received_ = 0;  ///< bytes since the latest complete answer
  std::string buffer_;
};

}  // namespace mlcca::net
