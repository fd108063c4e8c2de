// SPDX-License-Identifier: BSD-2-Clause
// Calls of gRPC to one member of the store: over HTTP/2, or to a fake.
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
  int status = kNoStatus;  ///< of gRPC; kNoStatus: it was not the server who ended it
  std::string text;        ///< for a person
  bool sent = true;        ///< false: surely nothing of the request has reached the server
  bool too_long = false;   ///< an answer was longer than kLongestAnswer
};

/// A call under way; it is over with this, and its functions are not called any more.
class Call {
 public:
  Call() = default;
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  Call(Call&&) = delete;
  Call& operator=(Call&&) = delete;
  virtual ~Call() = default;

  /// Some of the request may have reached the server.
  [[nodiscard]] virtual bool sent() const = 0;
};

struct Request {
  std::string_view method;
  std::string message;
  std::uint64_t timeout_ms = 0;  ///< 0: none
  bool stays_open = false;       ///< the server may go on to answer
  /// Once, unless it stays open.
  std::function<void(std::string)> on_answer;
  /// Once, at the end. With status 0 there was an answer.
  std::function<void(const End&)> on_end;
};

class Channel {
 public:
  Channel() = default;
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  Channel(Channel&&) = delete;
  Channel& operator=(Channel&&) = delete;
  virtual ~Channel() = default;

  /// Its functions are called from the loop, never within this call. They may end calls, this one
  /// included, but not the channel.
  [[nodiscard]] virtual std::unique_ptr<Call> start(Request request) = 0;
};

}  // namespace mlcca::cluster
