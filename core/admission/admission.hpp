// SPDX-License-Identifier: BSD-2-Clause
// The decision about one channel: which publisher may reach which place, given the description, the
// reservations so far and the present state of the networks. Pure: same input, same answer.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/admission/world.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/topology.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// The message that a delivery would have on a bus. `hop` is its position on the route; `message`
/// is nullopt if the description lacks what the message depends on.
struct TriedMessage {
  std::size_t hop = 0;
  std::optional<can::Message> message;
};

class Permits;

/// Whether the best cases hold that a delivery depends on, in the attribute set and on the route of
/// the verdict.
using BestCasesHold = std::function<bool(const Verdict& verdict)>;

/// Makes a decision assume that this gateway could reserve in the store whatever it needs.
struct Wish {
  /// Shared networks on which nothing can be reserved at present, with the reason.
  std::map<std::size_t, Obstacle> barred;
};

/// Everything that a decision depends on, by reference.
struct Situation {
  const System& system;
  const Topology& topology;
  const Members& members;
  const World& world;
  const std::vector<bool>& withdrawn;  ///< per channel: an operator has withdrawn it
  /// Design time: a best case does not refuse, since it is decided at run time. At run time it
  /// refuses.
  bool best_cases_pass = false;
  /// Design time: called for each delivery that depends on best cases; false refuses it. Null: all
  /// best cases hold.
  const BestCasesHold* hold = nullptr;
  /// Whether granted verdicts keep their hops (Verdict::hops), as at design time.
  bool keeps_hops = false;
  /// If not null, receives the messages tried on buses, also if an obstacle prevents a grant.
  std::vector<TriedMessage>* tried = nullptr;
  /// What this gateway may hold on shared networks; null: whatever fits.
  const Permits* permits = nullptr;
  const Wish* wish = nullptr;
  /// If not null, receives the channels of which a delivery is refused only because a permit is
  /// missing.
  std::set<std::size_t>* wished = nullptr;
};

/// Decides a channel in one attribute set and reserves what is granted. On entry the ledger must
/// hold nothing of the channel's publishers. With `before`, only deliveries are granted that were
/// granted there; each keeps its route if that is still possible, unless gateways on its routes are
/// elected or announce their presence (then the preferred route is chosen again).
[[nodiscard]] Decision decide_in(const Situation& situation, std::size_t channel, std::size_t set,
                                 Ledger& ledger, const Decision* before = nullptr);

/// Design time, after all channels have been decided: updates the response times of a decision to
/// those of the final schedules. Messages that were decided later have made them longer.
void renew_responses(const Situation& situation, Ledger& ledger, Decision& decision);

/// The number of attribute sets of a channel, at least 1.
[[nodiscard]] std::size_t sets_of(const System& system, std::size_t channel);

/// Whether every delivery that `before` grants is granted in `after`.
[[nodiscard]] bool keeps_grants(const Decision& before, const Decision& after);

/// The verdict of `decision` about the same publisher and place; null if there is none.
[[nodiscard]] const Verdict* same_delivery(const Decision& decision, const Verdict& verdict);

}  // namespace mlcca::core
