// SPDX-License-Identifier: BSD-2-Clause
// The decision: which publisher may reach which place, given what is described, what is promised
// already and what the interfaces can do now. Pure: same input, same answer.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/ledger.hpp"
#include "core/members.hpp"
#include "core/system.hpp"
#include "core/topology.hpp"
#include "core/verdict.hpp"

namespace mlcca::core {

/// What is known of a network now. A network that this gateway does not touch is taken as
/// described.
struct Condition {
  bool available = true;
  std::string problem;  ///< why not, in words
  bool operator==(const Condition&) const = default;
};

/// Everything that a decision looks at, by reference.
struct Situation {
  const System& system;
  const Topology& topology;
  const Members& members;
  const std::vector<Condition>& conditions;  ///< per network
  const std::vector<bool>& released;         ///< per channel: taken back by the operator
  /// At design time a best case passes: it is decided at run time, where it does not.
  bool best_cases_pass = false;
};

/// The verdicts of one channel, publishers and places in the order of their members, and the
/// ledger with what they reserve. `before` holds nothing of this channel. Of several attribute sets
/// the preferred one in which everything is granted counts; if there is none, the one in which most
/// deliveries are, for all ends alike.
struct ChannelDecision {
  std::vector<Verdict> verdicts;
  Ledger ledger;
};
[[nodiscard]] ChannelDecision decide(const Situation& situation, std::size_t channel,
                                     const Ledger& before);

/// All channels in the order of the description.
struct Decision {
  std::vector<std::vector<Verdict>> channels;
  Ledger ledger;
};
[[nodiscard]] Decision decide_all(const Situation& situation);

/// The same, handed over channel by channel with the ledger so far, so that nobody need keep all.
using EachChannel =
    std::function<void(std::size_t channel, std::vector<Verdict> verdicts, const Ledger& ledger)>;
Ledger decide_each(const Situation& situation, const EachChannel& each);

}  // namespace mlcca::core
