// SPDX-License-Identifier: BSD-2-Clause
// The framing of messages in gRPC, and the status at the end of a call. No I/O.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::cluster::grpc {

/// The status codes of gRPC (grpc-status) that are distinguished here.
inline constexpr int kOk = 0;
inline constexpr int kInvalidArgument = 3;
inline constexpr int kPermissionDenied = 7;
inline constexpr int kResourceExhausted = 8;
inline constexpr int kOutOfRange = 11;
inline constexpr int kUnavailable = 14;
inline constexpr int kUnauthenticated = 16;

/// The message behind the prefix of gRPC: one octet 0 (not compressed) and the length in four
/// octets.
[[nodiscard]] std::string framed(std::string_view message);

/// Extracts messages from a stream of gRPC frames.
class FrameReader {
 public:
  explicit FrameReader(std::size_t most) : most_(most) {}

  /// Takes received octets. False: a frame is compressed or longer than `most`; that frame and
  /// everything after it are discarded.
  [[nodiscard]] bool push(std::string_view octets);
  /// Removes and returns the next complete message; nullopt while there is none.
  [[nodiscard]] std::optional<std::string> next();
  /// Whether all octets that were pushed belong to messages that next() has returned.
  [[nodiscard]] bool at_end() const { return at_ == octets_.size(); }
  /// Whether a frame was longer than `most`.
  [[nodiscard]] bool too_long() const { return too_long_; }

 private:
  [[nodiscard]] bool is_right();

  std::size_t most_;
  std::string octets_;
  std::size_t at_ = 0;       ///< where the next frame begins
  std::size_t checked_ = 0;  ///< where the first frame begins whose prefix was not checked yet
  bool broken_ = false;
  bool too_long_ = false;
};

/// Collects the status of a call from its headers and trailers.
class Trailers {
 public:
  /// Takes one header line of HTTP. False: the response is not a gRPC response over HTTP/2; see
  /// problem().
  [[nodiscard]] bool take(std::string_view line);
  /// The value of grpc-status; nullopt if there was none.
  [[nodiscard]] std::optional<int> status() const { return status_; }
  /// The value of grpc-message as printable text of limited length.
  [[nodiscard]] const std::string& message() const { return message_; }
  /// Why the response is not a gRPC response; empty if it is.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::optional<int> status_;
  std::string message_;
  std::string problem_;
  std::size_t octets_ = 0;
};

}  // namespace mlcca::cluster::grpc
