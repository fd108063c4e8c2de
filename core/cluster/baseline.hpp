// SPDX-License-Identifier: BSD-2-Clause
// Standing promises: what the description alone grants of the networks that gateways share, in the
// described world. Every gateway with that description computes the same, and counts it always.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster {

class Baseline {
 public:
  explicit Baseline(const System& system);

  /// Flows rising.
  [[nodiscard]] std::span<const Standing> standing(std::size_t network) const {
    return standing_[network];
  }
  [[nodiscard]] const Standing* find(const Flow& flow) const;
  /// By network.
  [[nodiscard]] const std::vector<std::vector<Standing>>& all() const { return standing_; }

 private:
  std::vector<std::vector<Standing>> standing_;
};

}  // namespace mlcca::core::cluster
