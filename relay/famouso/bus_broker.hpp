// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's broker of one bus: deals node numbers and tags, and keeps them over restarts. A subject
// that the description has a tag for gets that one.
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

class BusBroker {
 public:
  /// Of requests on the bus, so that no node can keep the broker or its disk busy.
  static constexpr std::uint64_t kMostPerSecond = 200;

  using Stated = std::span<const TagBroker::Dealt>;
  using Log = std::function<void(const std::string&)>;

  /// `uid`: the broker's own, which gets the highest number. `file`: what was dealt before; then
  /// come the tags that are `stated`. An error: a stated tag was dealt otherwise before.
  static Result<BusBroker> make(const Uid& uid, DealtFile file, Stated stated, Log log);

  /// What is to be sent in answer, in this order. What could not be written down is not answered.
  std::vector<Frame> take(const Frame& frame, std::uint64_t now);
  /// What is to be sent since a node did not go on asking; call it at due().
  std::optional<Frame> expire(std::uint64_t now) { return nodes_.expire(now); }
  [[nodiscard]] std::optional<std::uint64_t> due() const { return nodes_.due(); }

  [[nodiscard]] std::size_t tags() const { return tags_.dealt().size(); }

 private:
  BusBroker(const Uid& uid, DealtFile file, std::span<const NodeBroker::Dealt> nodes, Stated tags,
            Log log)
      : file_(std::move(file)), nodes_(uid, nodes), tags_(tags), log_(std::move(log)) {}
  [[nodiscard]] bool may_answer(std::uint64_t now);
  [[nodiscard]] Result<void> write_down();

  DealtFile file_;
  NodeBroker nodes_;
  TagBroker tags_;
  Log log_;
  std::string trouble_;
  std::uint64_t second_ = 0;  ///< when it began, ns
  std::uint64_t answered_ = 0;
};

}  // namespace mlcca::relay
