// SPDX-License-Identifier: BSD-2-Clause
// The decision about one channel: which publisher may reach which place, given what is described,
// what is promised already and what the networks can do now. Pure: same input, same answer.
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

/// The message of a flow on a bus, the hop of that number of its route; nothing where the
/// description does not say enough.
struct TriedMessage {
  std::size_t hop = 0;
  std::optional<can::Message> message;
};

class Permits;

/// Whether the best cases hold that a delivery depends on, in the attribute set and on the way of
/// the verdict.
using BestCasesHold = std::function<bool(const Verdict& verdict)>;

/// What is decided as if everything were reserved that is needed.
struct Wish {
  /// Shared networks of which nothing can be reserved now, and why.
  std::map<std::size_t, Obstacle> barred;
};

/// Everything that a decision depends on, by reference.
struct Situation {
  const System& system;
  const Topology& topology;
  const Members& members;
  const World& world;
  const std::vector<bool>& withdrawn;  ///< per channel: by an operator
  /// At design time a best case passes: it is decided at run time, where it does not.
  bool best_cases_pass = false;
  /// Then: asked of each delivery that would be granted at best; null: all hold.
  const BestCasesHold* hold = nullptr;
  /// Verdicts have their hops, as at design time.
  bool keeps_hops = false;
  /// Gets what is tried on buses, also where an obstacle stands in the way.
  std::vector<TriedMessage>* tried = nullptr;
  /// What may be held of networks that gateways share; null: whatever fits.
  const Permits* permits = nullptr;
  const Wish* wish = nullptr;
  /// Gets the channels of which something is refused for want of a permit alone.
  std::set<std::size_t>* wished = nullptr;
};

/// Decides a channel in an attribute set and reserves what is granted. The ledger holds nothing of
/// its publishers. With `before`: nothing is granted that was not granted there, and what was keeps
/// its way if that is still possible and no gateway on any way announces itself.
[[nodiscard]] Decision decide_in(const Situation& situation, std::size_t channel, std::size_t set,
                                 Ledger& ledger, const Decision* before = nullptr);

/// Once everything is decided at design time: what is granted with the response times of the final
/// schedules, which messages that were decided later have made longer.
void renew_responses(const Situation& situation, Ledger& ledger, Decision& decision);

/// The number of attribute sets of a channel.
[[nodiscard]] std::size_t sets_of(const System& system, std::size_t channel);

/// Every delivery that was granted in `before` is granted in `after`.
[[nodiscard]] bool keeps_grants(const Decision& before, const Decision& after);

/// The verdict about the same publisher and place; null if there is none.
[[nodiscard]] const Verdict* same_delivery(const Decision& decision, const Verdict& verdict);

}  // namespace mlcca::core
