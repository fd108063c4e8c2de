// SPDX-License-Identifier: BSD-2-Clause
// Finds who has sent the frames that a slot refused because they are not the granted sender's. A
// gate keeps the latest senders of all its slots together, in a table of fixed size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/gates/plan.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

class MisfitSenders {
 public:
  /// How often the table of a gate is read in a round. Slots that are sampled later in that round
  /// get what was read last, so that a round stays short where frames come to very many slots.
  static constexpr unsigned kReadsOfRound = 64;

  /// `gates` must outlive this object.
  explicit MisfitSenders(const GateReader& gates) : gates_(gates) {}

  /// Starts a round, in which all slots are sampled once. What gates that are new have counted
  /// before is taken as the starting point. What a gate has noted before the last round began, and
  /// no sample has taken, lapses: its slot has counted it by then, in frames that nobody asked for.
  void begin_round();
  /// Takes what all gates have counted as the starting point.
  void forget() { of_ports_.clear(), begin_round(); }

  struct Sent {
    gates::RefusedSender sender;
    std::uint64_t frames = 0;
  };
  /// The senders of at most `frames` frames that the slot of an entry has refused since its last
  /// sample. To be called after the slot's counter was read: a gate notes a sender first. Fewer
  /// frames than that: the others are of senders that the gate does not keep any more, or were
  /// refused for other reasons.
  [[nodiscard]] std::vector<Sent> of(const core::GateEntry& entry, std::uint64_t frames);

 private:
  using BySender = std::map<std::size_t, gates::RefusedSender>;  ///< by place
  struct OfPort {
    int ifindex = 0;
    unsigned reads = 0;  ///< in this round
    std::vector<gates::RefusedSender> latest;
    BySender sampled;  ///< what was given
    BySender before;   ///< at the beginning of the last round
    BySender began;    ///< at the beginning of this round
  };

  const GateReader& gates_;
  std::map<std::size_t, OfPort> of_ports_;
};

}  // namespace mlcca
