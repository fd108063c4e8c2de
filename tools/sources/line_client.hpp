// SPDX-License-Identifier: BSD-2-Clause
// A client for a local server with a line protocol. It connects without blocking the event loop,
// and reconnects.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "base/handle.hpp"
#include "base/loop_timer.hpp"
#include "base/result.hpp"
#include "tools/sources/endpoint.hpp"
#include "tools/sources/peer.hpp"

namespace mlcca::net {

/// One connection at a time to the server, made again after each end.
class LineClient {
 public:
  /// Longest line in bytes; a server that sends a longer one is not the expected one.
  static constexpr std::size_t kLongestLine = std::size_t{64} << 10;
  /// Bytes of one answer, and bytes that are read in one turn of the loop.
  static constexpr std::size_t kLongestAnswer = std::size_t{4} << 20;
  static constexpr std::size_t kTurn = std::size_t{16} << 10;

  struct Handlers {
    std::function<void()> connected;
    /// Receives a line without its line ending. An incomplete line counts as a line when the server
    /// closes.
    std::function<void(std::string_view)> line;
    /// The connection has ended or was not made. `why` is empty if the server closed it.
    std::function<void(const std::string& why)> ended;
  };

  /// `pause` is the time in µs between the end of a connection and the next attempt. `patience` is
  /// the time in µs in which an answer must be complete, from the beginning or the answer before.
  /// Connects in the first turn of the loop. Handlers are called from the loop and must not destroy
  /// the client.
  LineClient(Endpoint endpoint, std::uint64_t pause, std::uint64_t patience, Handlers handlers);

  [[nodiscard]] Result<void> start(sd_event* loop);
  /// Sends a request. Requests are short: one that the socket does not take completely ends the
  /// connection.
  void send(std::string_view request);
  /// States that an answer is complete: its time and size are counted from 0 again.
  void complete();
  /// Ends the connection as if the server had; the next attempt follows after the pause.
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
  Listeners listeners_;  ///< listening sockets found before connecting
  std::uint64_t pause_;
  std::uint64_t patience_;
  Handlers handlers_;
  sd_event* loop_ = nullptr;
  Fd socket_;
  EventSource io_;
  LoopTimer timer_;
  bool connected_ = false;
  std::size_t received_ = 0;  ///< bytes since the latest complete answer
  std::string buffer_;
};

}  // namespace mlcca::net
