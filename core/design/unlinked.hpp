// SPDX-License-Identifier: BSD-2-Clause
// Finds meshes whose links nothing can know (MLCCA042).
#pragma once
#include <set>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/design/findings.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Collects where events enter such meshes and reports those meshes that matter.
class UnlinkedMeshes {
 public:
  explicit UnlinkedMeshes(const System& system);

  /// Adds a final verdict.
  void add(const Situation& situation, const Verdict& verdict);
  /// Reports those meshes over which events must travel, or that no event reaches. If all events
  /// leave a mesh at the node where they enter it, no link is missing.
  void report(std::vector<Finding>& to) const;

 private:
  const System& system_;
  std::set<std::size_t> meshes_{};   ///< indices of meshes without links
  std::set<std::size_t> visited_{};  ///< meshes that events reach
  std::set<std::size_t> crossed_{};  ///< meshes that events would cross from node to node
};

}  // namespace mlcca::core
