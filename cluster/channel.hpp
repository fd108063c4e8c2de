// SPDX-License-Identifier: BSD-2-Clause
// gRPC calls to one member of the store, as an interface: over HTTP/2 (http.hpp), or a fake in
// tests.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace mlcca::cluster {

inline constexpr std::size_t kLongestAnswer = std::size_t{16} << 20U;  ///< octets of one message

/// How a call has ended.
struct End {
  static constexpr int kNoStatus = -1;
  int status = kNoStatus;  ///< the gRPC status; kNoStatus: the call ended without one from the
                           ///< server
  std::string text;        ///< a description for a person
  bool sent = true;        ///< false: certainly nothing of the request has reached the server
  bool too_long = false;   ///< an answer exceeded kLongestAnswer
  bool stuck = false;  ///< the connection did not end the call in its time, and is to be given up
};

/// A call under way. Destroying it ends the call; its functions are not called afterwards.
class Call {
 public:
  Call() = default;
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  Call(Call&&) = delete;
  Call& operator=(Call&&) = delete;
  virtual ~Call() = default;

  /// Whether part of the request may have reached the server.
  [[nodiscard]] virtual bool sent() const = 0;
};

/// A request of one call.
struct Request {
  /// The path of the gRPC method, such as "/etcdserverpb.KV/Txn", and the encoded message.
  std::string_view method;
  std::string message;
  std::uint64_t timeout_ms = 0;  ///< 0: no limit
  bool stays_open = false;       ///< the server may send several answers, as for a watch
  /// Receives an answer: at most one, unless the call stays open.
  std::function<void(std::string)> on_answer;
  /// Is called once when the call has ended. With status 0 there was an answer before.
  std::function<void(const End&)> on_end;
};

/// A connection to one member, on which calls are started.
class Channel {
 public:
  Channel() = default;
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  Channel(Channel&&) = delete;
  Channel& operator=(Channel&&) = delete;
  virtual ~Channel() = default;

  /// Starts a call; nullptr if that is not possible. The functions of the request are called from
  /// the event loop and never within start(). They may destroy calls, also this one, but not the
  /// channel.
  [[nodiscard]] virtual std::unique_ptr<Call> start(Request request) = 0;
};

}  // namespace mlcca::cluster
