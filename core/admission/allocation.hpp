// SPDX-License-Identifier: BSD-2-Clause
// Divides scarce resources among the channels. Service comes before quality: no channel gets a
// better attribute set while one that could be granted has nothing. More important channels come
// first. Equally important ones take one step in turn, the oldest first, as in max-min fairness by
// progressive filling (Bertsekas, Gallager: Data Networks, 6.5.2), with attribute sets as the
// steps.
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

/// The phases of reallocation over the decisions and the ledger: keep, degrade, admit waiting,
/// upgrade. The caller chooses the channels and the order of the phases. It works in place on the
/// caller's decisions and ledger.
class Allocation {
 public:
  /// Former decisions, by channel.
  using Former = std::map<std::size_t, Decision>;

  /// `ages`: per channel, larger is younger; empty if all are equally old. `decisions`: per
  /// channel, changed in place; the ledger holds what they grant, except where a function says
  /// otherwise. `former`: if not null, receives each decision that is replaced for the first time.
  Allocation(const Situation& situation, std::span<const std::uint64_t> ages,
             std::vector<Decision>& decisions, Ledger& ledger, Former* former = nullptr)
      : s_(situation), ages_(ages), decisions_(decisions), ledger_(ledger), former_(former) {}

  /// Sorts channels in the order of service: by importance, then by age.
  void sort(std::vector<std::size_t>& channels) const;

  /// Gives sorted channels, of which the ledger holds nothing, what they had before. A channel that
  /// could not have that even alone gets the best set that it could have alone, or nothing. Returns
  /// false if other channels hold too much for that; ledger and decisions are unchanged then.
  [[nodiscard]] bool keep(const std::vector<std::size_t>& channels);
  /// Gives sorted channels, of which the ledger holds nothing, the lowest set in which all their
  /// former grants hold, the most important first. A channel that does not fit gets the set with
  /// the most grants, or nothing.
  void degrade(const std::vector<std::size_t>& channels);
  /// Decides again the sorted channels that have no grant. Returns true if one has a grant now.
  bool admit_waiting(const std::vector<std::size_t>& channels);
  /// Upgrades the sorted channels as far as resources allow, at no other channel's cost. Returns
  /// true if one got more or another route.
  bool upgrade(const std::vector<std::size_t>& channels);

  /// Removes all that a channel holds from the ledger.
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
  std::optional<Ledger> unloaded_;  // an empty ledger for alone(), made on demand
};

/// Whether no channel competes by importance or attribute set: each has one set and all are equally
/// important. Then deciding one channel after the other has the same result as the phases.
[[nodiscard]] bool is_plain(const System& system);

/// Decides all channels, with nothing granted before, and calls `each` once for each. In a plain
/// system it is called right after the channel's decision, so that the caller need not keep all.
using EachChannel = std::function<void(std::size_t channel, const Decision& decision)>;
void decide_each(const Situation& situation, Ledger& ledger, const EachChannel& each);

/// Decides channels that share nothing with other channels, with nothing granted before; the ledger
/// must hold nothing of them. `decisions` has an entry for each channel of the system.
void decide_some(const Situation& situation, std::vector<std::size_t> channels,
                 std::vector<Decision>& decisions, Ledger& ledger);

}  // namespace mlcca::core
