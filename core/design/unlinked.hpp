// SPDX-License-Identifier: BSD-2-Clause
// Meshes whose links nothing knows: MLCCA042.
#pragma once
#include <set>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/design/findings.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

class UnlinkedMeshes {
 public:
  explicit UnlinkedMeshes(const System& system);

  /// A verdict as it was decided in the end.
  void add(const Situation& situation, const Verdict& verdict);
  /// Those that something has to go over, or that nothing comes to. Where all events stay at the
  /// node that they come to, no link is missing.
  void report(std::vector<Finding>& to) const;

 private:
  const System& system_;
  std::set<std::size_t> meshes_{};   ///< networks
  std::set<std::size_t> visited_{};  ///< of them: events come there
  std::set<std::size_t> crossed_{};  ///< and would go from node to node
};

}  // namespace mlcca::core
