// SPDX-License-Identifier: BSD-2-Clause
// What best cases decide for others. A best case may hold at run time or not, and a channel whose
// best case does not hold leaves its room to others, or takes another way or another attribute set.
// Who shares something with it is granted for certain only what it gets whichever of them hold, and
// refused for certain only what it never gets.
//
// Example: a network has room for 20 kB/s. x needs 10 kB/s and arrives over a mesh whose links are
// measured; v needs 12 and w 5. If x is granted, v is refused; if not, v is granted. So v is
// decided at run time. w has room both ways: it is granted for certain.
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

class Contest {
 public:
  /// `situation`: lets best cases pass; it must outlive this.
  explicit Contest(const Situation& situation);

  /// By channel: how each is decided if all best cases hold. A channel that is missing was decided
  /// before any that has a best case, and depends on none.
  using Decisions = std::map<std::size_t, Decision>;

  /// Marks deliveries as decided at run time that are granted or refused depending on which best
  /// cases hold. Returns the channels whose attribute set depends on that, sorted.
  [[nodiscard]] std::vector<std::size_t> settle(Decisions& decisions);

 private:
  /// A delivery in an attribute set on a way: its best cases hold there or do not.
  using Question = std::tuple<std::size_t, Place, std::size_t, Route>;
  /// What a channel gets, over all that was tried.
  struct Range;
  class Answers;

  [[nodiscard]] std::vector<std::size_t> shared_by(std::size_t channel) const;
  [[nodiscard]] bool is_limited(std::size_t resource) const;
  void find_users();

  void settle_together(const std::vector<std::size_t>& channels, Decisions& decisions);
  [[nodiscard]] bool have_room_together(const std::vector<std::size_t>& channels,
                                        const Decisions& decisions);
  [[nodiscard]] bool holds_all_ways(std::size_t channel, const Decision& decision);
  [[nodiscard]] bool gets_all_that_it_can(std::size_t channel, const Decision& decision);
  [[nodiscard]] bool try_all(const std::vector<std::size_t>& channels, Decisions& decisions);
  void leave_open(const std::vector<std::size_t>& channels, Decisions& decisions);
  void take_out(const std::vector<std::size_t>& channels);

  const Situation& s_;
  Ledger ledger_;                ///< to try things out: empty between two calls
  std::vector<Decision> tried_;  ///< of each channel, as it was tried last
  std::vector<bool> uncertain_;  ///< by channel: something of it is granted at best
  std::vector<std::vector<std::size_t>> shared_;           ///< limited resources by channel
  std::map<std::size_t, std::vector<std::size_t>> users_;  ///< channels by resource
  std::set<std::size_t> open_sets_;
};

}  // namespace mlcca::core
