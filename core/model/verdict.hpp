// SPDX-License-Identifier: BSD-2-Clause
// An answer with its reasons: grant or refusal of one publisher towards one place.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/model/topology.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {

/// What an attribute was held against.
enum class Against : std::uint8_t {
  hop,          ///< one network or gateway of the route (Fig. 5)
  end_to_end,   ///< the composed provision of the route
  traffic,      ///< what the publisher offers, for one subscriber
  overhearing,  ///< the way to an intermediate network whose subscribers receive the event too
  capacity,     ///< what is left of a network
  schedule,     ///< a message of an analysed bus and its deadline, or the queue of a gateway there
  medium_time,  ///< what is left of the time of a mesh's domains, as payload bytes/s
};

struct Row {
  static constexpr std::uint32_t kBuiltIn = 0xffffffff;
  static constexpr std::uint32_t kOfGateway = 1U << 31U;

  Place place;  ///< hop, overhearing, capacity
  Comparison comparison{};
  /// capacity: promised to others; schedule: frames that the queue would have to hold, if it is too
  /// short.
  Value reserved = 0;
  /// traffic: the subscriber; schedule: the publisher who is late, or with kOfGateway the gateway
  /// that has reserved what would be late.
  std::uint32_t end = 0;
  std::uint32_t user = kBuiltIn;  ///< index of a user-defined attribute
  std::uint32_t room = 0;         ///< schedule: frames that the queue holds
  Against against = Against::hop;

  [[nodiscard]] bool is_user() const { return user != kBuiltIn; }
};

/// What a subscriber accepts of a payload: it may be less, as everywhere else it may be more.
[[nodiscard]] constexpr bool is_most(const Row& row) {
  return row.against == Against::traffic && row.user == Row::kBuiltIn &&
         row.comparison.attribute == Attribute::max_payload;
}

/// Why there is nothing to compare, or a comparison is beside the point.
enum class Obstacle : std::uint8_t {
  none,
  no_route,
  unavailable,      ///< the interface of a network is not available
  unbound,          ///< the channel has no identifier on a network
  no_node,          ///< the profile needs a node, the publisher states none
  too_long,         ///< the event does not fit the frames of a network
  no_traffic,       ///< a capacity to be held, and the publisher does not say what it sends
  no_data_rate,     ///< FD frames, and no bit rate is known for their data phase
  no_period,        ///< an analysed bus, and the publisher does not say how often it sends
  no_path,          ///< no links are known that lead through a mesh
  no_rate,          ///< the links that lead through a mesh are there, and their rates are unknown
  links_absent,     ///< who would know does not say that links that lead through a mesh are there
  links_must_last,  ///< they were lost, and are back since too short a time
  relay_gated,      ///< a gateway on the way through a mesh drops at its gate what its node relays
  no_sender,        ///< no program carries events across a gateway, from CAN to Ethernet or back
  renamed,          ///< the kernel would carry messages that name their PGN within, to another PGN
  untagged,         ///< the broker has not dealt the channel its tag on a network yet
  contradicted,     ///< the broker has dealt the channel's tag to another, or it another tag
  withdrawn,        ///< by an operator, until it is reinstated
  unlisted,         ///< the channel is not described, and a network admits no such channel
  sender_twice,     ///< another device sends the channel's identifier on a bus already
  echo,             ///< its events would come to a network twice, or go round over several gateways
  cluster,          ///< several gateways share a network, and this is not reserved there yet
  crowded,          ///< not all that is promised of a shared network fits there as it is now
  others_unknown,   ///< it is not known what other gateways hold of a network
};

/// What an analysed medium gives a flow: times on a CAN bus; over a mesh the way, whose rates
/// change with the others.
struct MediumUse {
  std::size_t network = 0;
  std::uint64_t key = 0;  ///< of the message on a bus
  Value response = 0;     ///< ns from arrival to the end of the last frame, as the bus is now
  Value guaranteed = 0;   ///< ns that whoever comes later cannot exceed
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  ///< nodes of the mesh, from and to
};

struct Verdict {
  std::size_t channel = 0;
  std::size_t publisher = 0;
  Place to;
  std::vector<std::size_t> subscribers;
  std::size_t set = 0;  ///< attribute set of the channel: 0 is the preferred one
  Outcome outcome = Outcome::unfit;
  bool granted = false;
  Obstacle obstacle = Obstacle::none;
  Place obstacle_at;
  Route route;               ///< the granted one, or the shortest that was tried
  AttributeSet requirement;  ///< strictest union
  UserValues user_requirement;
  AttributeSet provision;  ///< composed, end to end
  std::vector<Row> rows;
  std::vector<MediumUse> media;
  /// What each hop of the route gives these events, as the checks saw it: stated, and completed by
  /// what is computed for buses and meshes. Kept at design time only; empty with an obstacle.
  std::vector<Hop> hops;
  Value demand = 0;  ///< payload bytes/s reserved on each network of the route
  /// At design time: granted or not, depending on which best cases of others hold.
  bool contested = false;
};

/// The verdicts of a channel in one of its attribute sets, publishers and places in the order of
/// their members.
struct Decision {
  std::size_t set = 0;
  std::size_t granted = 0;
  std::vector<Verdict> verdicts;

  [[nodiscard]] bool all_granted() const { return granted == verdicts.size(); }
};

[[nodiscard]] inline bool is_unfit(const Row& row) {
  return row.comparison.outcome == Outcome::unfit;
}

/// Another row says the same of a refusal, or more: what a mesh has left is less than what it would
/// give to one alone, and what one hop cannot give, the whole way cannot.
[[nodiscard]] bool is_said_by_another(const Verdict& verdict, const Row& row);

/// Times of a way on which a message would come too late on a bus: how long it takes there is what
/// the row of the schedule says, and the others were compared without it.
[[nodiscard]] bool is_unknown_for_lateness(const Verdict& verdict, const Row& row);

/// Share of the better side that is left, in 1/1024: 0 is exactly met.
[[nodiscard]] Value slack(const Comparison& comparison);

/// The row that decided a refusal, or the one with the smallest relative margin of a grant.
[[nodiscard]] const Row* deciding_row(const Verdict& verdict);

/// What the worst-case reaction is the sum of: the required Omission and Period, the composed
/// Latency and Jitter.
[[nodiscard]] AttributeSet reaction_terms(const Verdict& verdict);

/// Time from the last heart-beat to the subscriber's certainty that it is missing, ns:
/// (Omission + 1) * Period + Latency + Jitter. Nothing where the channel is not periodic or a part
/// is not known.
[[nodiscard]] std::optional<Value> worst_case_reaction(const Verdict& verdict);

}  // namespace mlcca::core
