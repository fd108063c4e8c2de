// SPDX-License-Identifier: BSD-2-Clause
// What gRPC puts around messages, and what it says at the end of a call. No I/O here.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::cluster::grpc {

/// What a call ends with (grpc-status) as far as it makes a difference here.
inline constexpr int kOk = 0;
inline constexpr int kInvalidArgument = 3;
inline constexpr int kPermissionDenied = 7;
inline constexpr int kResourceExhausted = 8;
inline constexpr int kOutOfRange = 11;
inline constexpr int kUnavailable = 14;
inline constexpr int kUnauthenticated = 16;

/// The message behind five octets: not compressed, and its length.
[[nodiscard]] std::string framed(std::string_view message);

/// Takes messages out of the frames that they come in.
class FrameReader {
 public:
  explicit FrameReader(std::size_t most) : most_(most) {}

  /// False: a frame is compressed or longer than `most`. Nothing is read of it, nor after it.
  [[nodiscard]] bool push(std::string_view octets);
  /// The next message that is whole.
  [[nodiscard]] std::optional<std::string> next();
  /// What was pushed ends with a whole message.
  [[nodiscard]] bool at_end() const { return at_ == octets_.size(); }
  /// A frame was longer than `most`.
  [[nodiscard]] bool too_long() const { return too_long_; }

 private:
  [[nodiscard]] bool is_right();

  std::size_t most_;
  std::string octets_;
  std::size_t at_ = 0;       ///< where the next frame begins
  std::size_t checked_ = 0;  ///< where the first frame begins whose head was not seen
  bool broken_ = false;
  bool too_long_ = false;
};

/// What the headers and trailers of a call say.
class Trailers {
 public:
  /// A line as HTTP has it. False: this is no call of gRPC over HTTP/2.
  [[nodiscard]] bool take(std::string_view line);
  /// grpc-status; nothing: there was none.
  [[nodiscard]] std::optional<int> status() const { return status_; }
  /// grpc-message, as printable text of limited length.
  [[nodiscard]] const std::string& message() const { return message_; }
  /// Why it is no call of gRPC.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::optional<int> status_;
  std::string message_;
  std::string problem_;
  std::size_t octets_ = 0;
};

}  // namespace mlcca::cluster::grpc
