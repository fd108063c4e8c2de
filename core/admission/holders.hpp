// SPDX-License-Identifier: BSD-2-Clause
// Who holds how much of a shared network, for people: what a refusal for lack of room names, and
// which gateways claim more than there is.
#pragma once
#include <cstddef>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/admission/world.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// For which other gateways one has reserved something: it has admitted the publishers, and they
/// the subscribers.
struct MadeFor {
  std::set<std::size_t> gateways;
  bool all = true;  ///< it has reserved nothing else there
  bool operator==(const MadeFor&) const = default;
};

/// What one gateway has reserved of a network. Traffic that several of its reservations contain
/// counts once.
struct HeldBy {
  std::size_t gateway = 0;
  Value bytes_per_second = 0;       ///< payload
  std::size_t messages = 0;         ///< on a bus
  Value bus_time = 0;               ///< of a bus, in 1e-6 of its time
  std::vector<mesh::Share> shares;  ///< of the domains of a mesh, as its links are now
  std::size_t uncountable = 0;      ///< messages and paths that cannot be counted as the network
                                    ///< is now
  MadeFor made_for;
  bool operator==(const HeldBy&) const = default;
};

/// The source of what gateways hold, in the numbers of the gateways that have reserved it.
class Holdings {
 public:
  Holdings() = default;
  Holdings(const Holdings&) = delete;
  Holdings& operator=(const Holdings&) = delete;
  Holdings(Holdings&&) = delete;
  Holdings& operator=(Holdings&&) = delete;
  virtual ~Holdings() = default;
  /// What other gateways have reserved of the network, whether or not this one carries it as well.
  /// What is being decided is not a part of it.
  [[nodiscard]] virtual cluster::Foreign of_others(std::size_t network) const = 0;
  /// By the gateway that has reserved it.
  [[nodiscard]] virtual std::map<std::size_t, MadeFor> made_for(std::size_t network) const = 0;
  /// Which entries cannot be read, so that it is not known what others hold of the network, and
  /// what to do; empty if all can be read.
  [[nodiscard]] virtual std::string unreadable(std::size_t network) const = 0;
  /// Which of the gateways does not carry the channel, and why, after the latest try: "gateway g1:
  /// …". Empty if none of them has objected, or nothing that is known of others counts.
  [[nodiscard]] virtual std::string objection(std::size_t channel,
                                              std::span<const std::size_t> gateways) const = 0;
};

/// Adds up what gateways hold, by rising index of the gateway.
[[nodiscard]] std::vector<HeldBy> held_by(const System& system, const World& world,
                                          std::size_t network, const cluster::Foreign& parts);

/// Names the gateways with the largest amounts, and how many more there are: "gw2 (400 kB/s), gw3
/// (100 kB/s, in part for gw1) and 2 more gateways". Empty if there are none.
[[nodiscard]] std::string holders_words(const System& system, std::size_t network,
                                        std::span<const HeldBy> held);

/// If the gateways together hold more of the network than it has: how much that is, and who they
/// are. Empty otherwise.
[[nodiscard]] std::string excess_words(const System& system, const World& world,
                                       std::size_t network, std::span<const HeldBy> held);

/// Names the gateways with reservations that cannot be counted as the network is now; empty if
/// there are none.
[[nodiscard]] std::string uncountable_words(const System& system, std::span<const HeldBy> held);

}  // namespace mlcca::core
