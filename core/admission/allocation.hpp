// SPDX-License-Identifier: BSD-2-Clause
// Which channel is given what when it does not suffice for all. Service comes before quality: no
// channel gets a better attribute set while one that could be granted has nothing. The more
// important channel comes first; of equally important ones each takes one step in turn, the older
// first, as in max-min fairness by progressive filling (Bertsekas, Gallager: Data Networks, 6.5.2),
// with attribute sets as the steps.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

class Allocation {
 public:
  /// Of channels: what was decided before.
  using Former = std::map<std::size_t, Decision>;

  /// `ages`: of each channel, the larger the younger; none: all are equally old. `decisions`: of
  /// each channel, changed in place. What they grant is in the ledger, except where it says
  /// otherwise. `former`: gets what is replaced, the first time that it is.
  Allocation(const Situation& situation, std::span<const std::uint64_t> ages,
             std::vector<Decision>& decisions, Ledger& ledger, Former* former = nullptr)
      : s_(situation), ages_(ages), decisions_(decisions), ledger_(ledger), former_(former) {}

  /// In the order in which they are served.
  void sort(std::vector<std::size_t>& channels) const;

  /// Gives sorted channels, of which the ledger holds nothing, what they had. One that could not
  /// have it even alone gets the best set in which it could, or nothing. False if the others hold
  /// too much for that: then the ledger and the decisions are as before.
  [[nodiscard]] bool keep(const std::vector<std::size_t>& channels);
  /// Gives sorted channels, of which the ledger holds nothing, their lowest set that serves them no
  /// less than before, the most important first; who does not fit then gets nothing.
  void degrade(const std::vector<std::size_t>& channels);
  /// Decides again those of the sorted channels that are granted nothing. True if one is granted
  /// now.
  bool admit_waiting(const std::vector<std::size_t>& channels);
  /// Gives the sorted channels more, as far as there is more, at no other channel's cost. True if
  /// one got more, or takes another way.
  bool upgrade(const std::vector<std::size_t>& channels);

  /// Takes what a channel holds out of the ledger.
  void take_out(std::size_t channel);

 private:
  void put(std::size_t channel, Decision decision);
  [[nodiscard]] Decision alone(std::size_t channel);
  [[nodiscard]] std::optional<Decision> lowered(std::size_t channel, const Decision& before);
  [[nodiscard]] static bool takes_another_way(const Decision& before, const Decision& after);
  bool step_up(std::size_t channel);
  [[nodiscard]] bool is_best(std::size_t channel) const;
  [[nodiscard]] std::uint8_t importance(std::size_t channel) const {
    return s_.system.channels[channel].importance;
  }

  Situation s_;
  std::span<const std::uint64_t> ages_;
  std::vector<Decision>& decisions_;
  Ledger& ledger_;
  Former* former_;
  std::optional<Ledger> unloaded_;  // as if no channel held anything
};

/// There is nothing to be divided: one set each, all equally important. Then serving one channel
/// after the other gives the same.
[[nodiscard]] bool is_plain(const System& system);

/// Decides everything, with nothing granted before. `each` is called for every channel; with a
/// plain system right after its decision, so that the caller need not keep all of them.
using EachChannel = std::function<void(std::size_t channel, const Decision& decision)>;
void decide_each(const Situation& situation, Ledger& ledger, const EachChannel& each);

/// Decides some channels that share nothing with the others, with nothing granted before. Of them
/// the ledger holds nothing. `decisions`: of each channel of the system.
void decide_some(const Situation& situation, std::vector<std::size_t> channels,
                 std::vector<Decision>& decisions, Ledger& ledger);

}  // namespace mlcca::core
