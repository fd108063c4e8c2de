// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's broker of one bus.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/result.hpp"
#include "relay/famouso/dealt_file.hpp"
#include "relay/famouso/node_numbers.hpp"
#include "relay/famouso/tag_broker.hpp"
#include "relay/layers/can_layer.hpp"

namespace mlcca::relay {

/// Assigns node numbers and tags on one bus, and stores them so that they survive restarts. A
/// subject gets the tag that the description states for it, if there is one.
class BusBroker {
 public:
  /// Requests that are answered in a second, so that no node can keep the broker or its disk busy.
  static constexpr std::uint64_t kMostPerSecond = 200;

  using Stated = std::span<const TagBroker::Dealt>;
  using Log = std::function<void(const std::string&)>;

  /// `uid`: UID of the broker itself, which gets the highest number. `file`: earlier assignments.
  /// `stated`: tags that the description states. Fails if a stated tag contradicts an earlier
  /// assignment.
  static Result<BusBroker> make(const Uid& uid, DealtFile file, Stated stated, Log log);

  /// Returns the frames to send in answer, in this order. A request is not answered if its
  /// assignment could not be stored.
  std::vector<Frame> take(const Frame& frame, std::uint64_t now);
  /// Returns the frame to send because a node has stopped its requests; to be called at due().
  std::optional<Frame> expire(std::uint64_t now) { return nodes_.expire(now); }
  [[nodiscard]] std::optional<std::uint64_t> due() const { return nodes_.due(); }

  [[nodiscard]] std::size_t tags() const { return tags_.dealt().size(); }

 private:
  BusBroker(const Uid& uid, DealtFile file, std::span<const NodeBroker::Dealt> nodes, Stated tags,
            Log log)
      : file_(std::move(file)), nodes_(uid, nodes), tags_(tags), log_(std::move(log)) {}
  [[nodiscard]] bool may_answer(std::uint64_t now);
  [[nodiscard]] Result<void> write_down();
  void say_what_is_used_up();

  DealtFile file_;
  NodeBroker nodes_;
  TagBroker tags_;
  Log log_;
  std::string trouble_;
  bool says_numbers_ = true;  ///< it has not logged yet that all numbers are assigned
  bool says_tags_ = true;     ///< the same of tags
  std::uint64_t second_ = 0;  ///< when the present second began, ns
  std::uint64_t answered_ = 0;
};

}  // namespace mlcca::relay
