// SPDX-License-Identifier: BSD-2-Clause
// Why a slot refused frames. A gate counts frames by slot, and by reason for all of its slots; of a
// slot it keeps the latest reason alone.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/gates/plan.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

class MisfitCauses {
 public:
  /// It must outlive this.
  explicit MisfitCauses(const GateDriver& gates) : gates_(gates) {}

  /// All slots are sampled from now on, and were sampled since the call before.
  void begin_round();
  /// The counters start from 0.
  void forget() { before_.clear(), began_.clear(); }

  struct Cause {
    std::string reason;  ///< in words
    std::uint64_t frames = 0;
    bool operator==(const Cause&) const = default;
  };
  /// Of the frames that a slot has refused between its sample in the round before and its sample
  /// now. Exact where the gate refused frames for one reason meanwhile, or those of one slot; else
  /// one cause that says the latest.
  [[nodiscard]] std::vector<Cause> of(const core::GateEntry& entry, Fate fate, std::uint64_t frames,
                                      const std::string& latest) const;

 private:
  using Counts = std::map<std::size_t, std::vector<Refusals>>;  ///< by port

  const GateDriver& gates_;
  Counts before_;  ///< when the round before began
  Counts began_;   ///< when this round did
};

}  // namespace mlcca
