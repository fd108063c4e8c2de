// SPDX-License-Identifier: BSD-2-Clause
// Standing promises: what the description alone grants on shared networks, in the described world.
// Every gateway with that description computes the same and always counts it.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster {

/// The standing promises of a System, computed once.
class Baseline {
 public:
  explicit Baseline(const System& system);

  /// The promises on a network, sorted by flow.
  [[nodiscard]] std::span<const Standing> standing(std::size_t network) const {
    return standing_[network];
  }
  /// The promise to a flow; null if there is none.
  [[nodiscard]] const Standing* find(const Flow& flow) const;
  /// The promises of all networks, by network.
  [[nodiscard]] const std::vector<std::vector<Standing>>& all() const { return standing_; }

 private:
  std::vector<std::vector<Standing>> standing_;
};

}  // namespace mlcca::core::cluster
