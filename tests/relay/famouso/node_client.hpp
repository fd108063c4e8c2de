// SPDX-License-Identifier: BSD-2-Clause
// The node's side of the protocol that node_numbers.hpp describes, which the relay serves.
#pragma once
#include <cstdint>
#include <optional>

#include "relay/famouso/node_numbers.hpp"

namespace mlcca::relay {

/// A node, as FAMOUSO's own: requests a number. Times are CLOCK_MONOTONIC in ns.
class NodeClient {
 public:
  /// Without an answer the client begins again after kFirstWait; the time doubles up to
  /// kLongestWait (ns).
  static constexpr std::uint64_t kFirstWait = 250'000'000;
  static constexpr std::uint64_t kLongestWait = 8'000'000'000;

  /// `uid` must not be zero, since such a node gets no number.
  explicit NodeClient(const Uid& uid) : uid_(uid) {}

  /// Returns the first request.
  Frame start(std::uint64_t now);
  /// Takes a frame and returns the next request to send, if any.
  std::optional<Frame> take(const Frame& frame, std::uint64_t now);
  /// Returns the request to repeat if due() has passed.
  std::optional<Frame> expire(std::uint64_t now);
  [[nodiscard]] std::uint64_t due() const { return due_; }

  [[nodiscard]] std::optional<NodeNumber> number() const { return number_; }

 private:
  [[nodiscard]] Frame request() const;
  Frame restart(std::uint64_t now);
  [[nodiscard]] bool agrees(const Frame& answer) const;

  Uid uid_;
  unsigned stage_ = 15;
  bool silent_ = false;  ///< another node is served first
  std::uint64_t wait_ = kFirstWait;
  std::uint64_t due_ = ~std::uint64_t{0};
  std::optional<NodeNumber> number_;
};

}  // namespace mlcca::relay
