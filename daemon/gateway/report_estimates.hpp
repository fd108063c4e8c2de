// SPDX-License-Identifier: BSD-2-Clause
// Estimates whether a report is too large to be made in one turn of the loop.
#pragma once
#include <cstddef>

#include "core/admission/state.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

class ReportEstimates {
 public:
  /// All references must outlive this object.
  ReportEstimates(const Scene& scene, const GateReader& gates, const CanForwarding& forwarding,
                  const Meshes& meshes)
      : scene_(scene), gates_(gates), forwarding_(forwarding), meshes_(meshes) {}

  /// Of a report of everything, also if it lists only a part.
  [[nodiscard]] bool is_large() const;
  [[nodiscard]] bool has_many_ends(std::size_t channel) const;
  [[nodiscard]] bool has_many_lines(std::size_t channel) const;
  [[nodiscard]] bool has_channel_of_many_ends() const;

 private:
  const Scene& scene_;
  const GateReader& gates_;
  const CanForwarding& forwarding_;
  const Meshes& meshes_;
};

}  // namespace mlcca
