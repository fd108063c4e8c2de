// SPDX-License-Identifier: BSD-2-Clause
// Sharing of equal endpoints between the channels of a program.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "control/messages.hpp"

namespace mlcca::client {

using SharedEndpoint = std::shared_ptr<const control::Endpoint>;

/// Returns one shared copy of equal endpoints. Where frames carry the subject, most channels of a
/// network have the same endpoint, and there may be thousands of them.
class SharedEndpoints {
 public:
  SharedEndpoint share(control::Endpoint endpoint) {
    if (endpoint.ifindex == 0)
      return std::make_shared<const control::Endpoint>(std::move(endpoint));
    if (known_.size() >= sweep_at_) {
      std::erase_if(known_, [](const auto& one) { return one.second.expired(); });
      sweep_at_ = std::max(kLeastSweep, 2 * known_.size());
    }
    auto& known = known_[{endpoint.ifindex, endpoint.id}];
    if (auto same = known.lock(); same && *same == endpoint) return same;
    auto fresh = std::make_shared<const control::Endpoint>(std::move(endpoint));
    known = fresh;
    return fresh;
  }

 private:
  static constexpr std::size_t kLeastSweep = 64;
  /// The latest endpoint of each interface and identifier.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::weak_ptr<const control::Endpoint>> known_;
  std::size_t sweep_at_ = kLeastSweep;
};

}  // namespace mlcca::client
