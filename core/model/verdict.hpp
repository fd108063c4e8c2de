// SPDX-License-Identifier: BSD-2-Clause
// The answer to one request with its reasons: a grant or refusal of one publisher towards one
// place.
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

/// What a row compares a requirement with.
enum class Against : std::uint8_t {
  hop,          ///< one network or gateway of the route (Fig. 5)
  end_to_end,   ///< the composed provision of the route
  traffic,      ///< what the publisher sends, compared with what one subscriber requires
  overhearing,  ///< the route up to a network on the way whose subscribers receive the event
  capacity,     ///< the free capacity of a network
  schedule,  ///< the response time of a message on an analysed bus and its deadline, or the length
             ///< of a gateway's queue there
  medium_time,  ///< the free medium time of a mesh's contention domains, expressed as payload
                ///< bytes/s
};

/// One comparison of a verdict: which attribute, where, required against provided.
struct Row {
  /// Value of `user` for a built-in attribute.
  static constexpr std::uint32_t kBuiltIn = 0xffffffff;
  /// Bit of `end` that makes the rest the index of a gateway.
  static constexpr std::uint32_t kOfGateway = 1U << 31U;

  Place place;  ///< the network or gateway that the row is about (hop, overhearing, capacity,
                ///< schedule, medium_time)
  Comparison comparison{};
  /// capacity: bytes/s promised to others. schedule: the number of frames that the queue would have
  /// to hold, if it is too short.
  Value reserved = 0;
  /// traffic: index of the subscriber. schedule: index of the publisher whose frames would be late;
  /// with the bit kOfGateway the index of the gateway whose reservation would be late.
  std::uint32_t end = 0;
  std::uint32_t user = kBuiltIn;  ///< index of a user-defined attribute, or kBuiltIn
  std::uint32_t room = 0;         ///< schedule: frames that the queue holds
  Against against = Against::hop;

  [[nodiscard]] bool is_user() const { return user != kBuiltIn; }
};

/// Whether the row's requirement is an upper limit although MaxPayload is otherwise better when
/// larger: a subscriber states the longest payload that it accepts, and the publisher must not
/// exceed it.
[[nodiscard]] constexpr bool is_most(const Row& row) {
  return row.against == Against::traffic && row.user == Row::kBuiltIn &&
         row.comparison.attribute == Attribute::max_payload;
}

/// The reason of a refusal that is not a comparison of values.
enum class Obstacle : std::uint8_t {
  none,
  no_route,
  unavailable,      ///< a network cannot be used, see Condition::problem
  unbound,          ///< the channel has no identifier on a network
  no_node,          ///< the profile needs a node number, and the publisher states none
  too_long,         ///< the event does not fit the frames of a network
  no_traffic,       ///< the network has a capacity, and the publisher does not state its traffic
  no_data_rate,     ///< FD frames are needed, and the bit rate of their data phase is unknown
  no_period,        ///< response times on the bus are analysed, and the publisher states no Period
  no_path,          ///< no links are known that form a path through a mesh
  no_rate,          ///< the links through a mesh are present, and their rates are unknown
  links_absent,     ///< the source that reports the presence of links does not report those that a
                    ///< path needs
  links_must_last,  ///< the links were lost, and are back for less than the hold time of the mesh
  relay_gated,      ///< on the path through a mesh a gateway's gate would drop what its node relays
  no_sender,  ///< events must cross a gateway by a program (e.g. from CAN to Ethernet), and there
              ///< is none
  renamed,  ///< the kernel would forward a multi-frame message that names its PGN inside to another
            ///< PGN
  untagged,        ///< the FAMOUSO broker has not assigned a tag to the channel on a network yet
  contradicted,    ///< the broker assigned the channel's tag to another subject, or another tag to
                   ///< the channel
  withdrawn,       ///< an operator has withdrawn it, until it is reinstated
  unlisted,        ///< the channel is not described, and a network admits no channel that is not
  sender_twice,    ///< another device already sends the channel's identifier on a bus
  echo,            ///< its events would reach a network twice, or circulate over several gateways
  cluster,         ///< several gateways share a network, and this is not reserved in the store yet
  disagreed,       ///< another gateway on the way has not agreed to carry it
  crowded,         ///< not everything that is promised on a shared network fits there at present
  others_unknown,  ///< it is unknown what other gateways hold of a network
};

/// What an analysed medium gives to one flow: response times on a CAN bus, or the path through a
/// mesh (not its rates, since these change with the other flows).
struct MediumUse {
  std::size_t network = 0;
  std::uint64_t key = 0;  ///< identifies the message on the bus
  Value response = 0;    ///< ns from arrival to the end of the last frame, with the present load of
                         ///< the bus
  Value guaranteed = 0;  ///< ns that are not exceeded whatever is admitted later
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  ///< mesh nodes: (from, to)
};

/// The answer for one publisher of a channel towards one place. Indices refer to Members and
/// System.
struct Verdict {
  std::size_t channel = 0;
  std::size_t publisher = 0;
  Place to;
  std::vector<std::size_t> subscribers;
  std::size_t set = 0;  ///< attribute set of the channel: 0 is the preferred one
  Outcome outcome = Outcome::unfit;
  bool granted = false;
  bool sporadic = false;  ///< see EventChannel::arrival
  Obstacle obstacle = Obstacle::none;
  Place obstacle_at;
  Route route;               ///< the granted route, or the shortest that was tried
  AttributeSet requirement;  ///< strictest union of all requirements
  UserValues user_requirement;
  AttributeSet provision;  ///< composed over the route, end to end
  std::vector<Row> rows;
  std::vector<MediumUse> media;
  /// What each hop of the route provides for these events, as the checks used it: the stated
  /// provision, completed by what is computed for buses and meshes. Filled at design time only;
  /// empty if there is an obstacle.
  std::vector<Hop> hops;
  Value demand = 0;  ///< payload bytes/s reserved on each network of the route
  /// Design time only: whether it is granted depends on which best cases of other channels hold.
  bool contested = false;
};

/// All verdicts of a channel in one of its attribute sets, ordered by publisher and place.
/// `granted` counts the granted ones.
struct Decision {
  std::size_t set = 0;
  std::size_t granted = 0;
  std::vector<Verdict> verdicts;

  [[nodiscard]] bool all_granted() const { return granted == verdicts.size(); }
};

[[nodiscard]] inline bool is_unfit(const Row& row) {
  return row.comparison.outcome == Outcome::unfit;
}

/// Whether another row makes this row of a refusal redundant: the free time of a mesh is never more
/// than what the path gives to a single flow, and what one hop cannot provide, the route cannot
/// either.
[[nodiscard]] bool is_said_by_another(const Verdict& verdict, const Row& row);

/// Whether the row compares a time on a route on which a message would be late on a bus. The
/// schedule row states that time; this row was computed without it.
[[nodiscard]] bool is_unknown_for_lateness(const Verdict& verdict, const Row& row);

/// The relative margin of a comparison in 1/1024 of the larger of the two values; 0: exactly met.
[[nodiscard]] Value slack(const Comparison& comparison);

/// The row that explains the verdict: of a refusal the one that refused, of a grant the one with
/// the smallest relative margin. Null if no row qualifies.
[[nodiscard]] const Row* deciding_row(const Verdict& verdict);
/// The network or gateway at which a refused delivery fails; nullopt if that is no single one, or
/// the delivery is granted.
[[nodiscard]] std::optional<Place> refusing_hop(const Verdict& verdict);

/// The terms of the worst-case reaction: the required Omission and Period, and the provided Latency
/// and Jitter.
[[nodiscard]] AttributeSet reaction_terms(const Verdict& verdict);

/// Time from the last heart-beat until the subscriber knows that it is missing, in ns:
/// (Omission + 1) * Period + Latency + Jitter. Nullopt if the channel is not periodic or a term is
/// unknown.
[[nodiscard]] std::optional<Value> worst_case_reaction(const Verdict& verdict);

}  // namespace mlcca::core
