// SPDX-License-Identifier: BSD-2-Clause
// What best cases decide for other channels. A best case may or may not hold at run time. A channel
// whose best case does not hold leaves its room to others, or takes another route or attribute set.
// So channels that share something with it are granted with certainty only what they get in every
// case, and refused with certainty only what they never get.
//
// Example: a network has room for 20 kB/s. x needs 10 kB/s and arrives over a mesh whose links are
// measured; v needs 12 and w 5. If x is granted, v is refused; if not, v is granted. So v is
// decided at run time. w has room in both cases: it is granted with certainty.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// Tries the combinations of best cases, and marks the decisions that depend on them.
class Contest {
 public:
  /// `situation` must let best cases pass and must outlive this.
  explicit Contest(const Situation& situation);

  /// By channel: the decision if all best cases hold. A missing channel was decided before any with
  /// a best case and depends on none.
  using Decisions = std::map<std::size_t, Decision>;

  /// Marks deliveries as decided at run time whose grant depends on which best cases hold. Returns
  /// the channels whose attribute set depends on that, sorted.
  [[nodiscard]] std::vector<std::size_t> mark(Decisions& decisions);

 private:
  /// A delivery in an attribute set on a route, whose best cases hold or do not.
  using Question = std::tuple<std::size_t, Place, std::size_t, Route>;
  /// What a channel gets over all cases that were tried.
  struct Range;
  class Answers;

  [[nodiscard]] std::vector<std::size_t> shared_by(std::size_t channel) const;
  [[nodiscard]] bool is_limited(std::size_t resource) const;
  void find_users();

  void mark_together(const std::vector<std::size_t>& channels, Decisions& decisions);
  [[nodiscard]] bool have_room_together(const std::vector<std::size_t>& channels,
                                        const Decisions& decisions);
  [[nodiscard]] bool holds_all_ways(std::size_t channel, const Decision& decision);
  [[nodiscard]] bool gets_all_that_it_can(std::size_t channel, const Decision& decision);
  [[nodiscard]] bool try_all(const std::vector<std::size_t>& channels, Decisions& decisions);
  void leave_open(const std::vector<std::size_t>& channels, Decisions& decisions);
  void take_out(const std::vector<std::size_t>& channels);

  const Situation& s_;
  Ledger ledger_;                ///< for trying; empty between two calls
  std::vector<Decision> tried_;  ///< by channel: its last tried decision
  std::vector<bool> uncertain_;  ///< by channel: something of it depends on a best case
  std::vector<std::vector<std::size_t>> shared_;           ///< limited resources by channel
  std::map<std::size_t, std::vector<std::size_t>> users_;  ///< channels by resource
  std::set<std::size_t> open_sets_;
};

}  // namespace mlcca::core
