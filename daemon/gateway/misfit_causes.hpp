// SPDX-License-Identifier: BSD-2-Clause
// Finds the reasons for which a slot refused frames. A gate counts frames per slot, and per reason
// for all its slots together; of a slot it keeps only the latest reason.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "core/gates/frame_reason.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

class MisfitCauses {
 public:
  /// `gates` must outlive this object.
  explicit MisfitCauses(const GateReader& gates) : gates_(gates) {}

  /// Starts a round, in which all slots are sampled once.
  void begin_round();
  /// Forgets all counts, because the counters of the gates start from 0.
  void forget() { before_.clear(), began_.clear(), explained_.clear(); }
  /// The senders of so many frames of an entry are known: they are none of those that of() explains
  /// in the rest of this round.
  void explain(const core::GateEntry& entry, Fate fate, core::FrameReason reason,
               std::uint64_t frames);

  struct Cause {
    core::StatedReason reason;
    std::uint64_t frames = 0;
    bool operator==(const Cause&) const = default;
  };
  /// The causes of the `frames` that a slot has refused between its samples in the last round and
  /// in this one. Exact if the gate refused frames only for one reason, or only of one slot;
  /// otherwise one cause with the latest reason.
  [[nodiscard]] std::vector<Cause> of(const core::GateEntry& entry, Fate fate, std::uint64_t frames,
                                      std::optional<core::FrameReason> latest) const;

 private:
  using Counts = std::map<std::size_t, std::vector<Refusals>>;  ///< by port
  /// Frames by port, direction, fate and reason.
  using Explained = std::map<std::tuple<std::size_t, bool, Fate, core::FrameReason>, std::uint64_t>;

  const GateReader& gates_;
  Counts before_;        ///< at the beginning of the last round
  Counts began_;         ///< at the beginning of this round
  Explained explained_;  ///< in this round
};

}  // namespace mlcca
