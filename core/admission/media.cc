// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/media.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/admission/provided.hpp"
#include "core/admission/route_check.hpp"
#include "core/can/of_system.hpp"
#include "core/gates/relay_gate.hpp"
#include "core/mesh/roles.hpp"
#include "core/model/carrier.hpp"
#include "core/model/medium.hpp"
#include "mlcca/arithmetic.hpp"
#include "mlcca/check.hpp"

namespace mlcca::core {
namespace {

Value less(Value a, Value b) {
  if (a == kUnbounded) return a;
  return a > b ? a - b : 0;
}

/// Whether any source of the mesh can report the rates of links.
bool may_know_rates(const mesh::Mesh& mesh) {
  return std::ranges::any_of(mesh.sources, mesh::knows_rates);
}

/// Whether only the description states the links of the mesh, so that they never change. A mesh
/// without any source has no links at all (MLCCA042).
bool is_fixed(const mesh::Mesh& mesh) { return !mesh::is_measured(mesh); }

bool is_empty(const AttributeSet& offered) {
  return offered.has(Attribute::max_payload) && offered[Attribute::max_payload] == 0;
}

Obstacle obstacle_of(std::optional<mesh::Lack> lack) {
  if (lack == mesh::Lack::rate) return Obstacle::no_rate;
  if (lack == mesh::Lack::time) return Obstacle::links_must_last;
  if (lack == mesh::Lack::absent) return Obstacle::links_absent;
  return Obstacle::no_path;
}

/// The nodes of a gateway, or for a network all nodes of the mesh.
std::vector<std::uint32_t> nodes_of(const mesh::Mesh& mesh, Place place) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t n = 0; n < mesh.nodes.size(); ++n)
    if (place.kind == Place::Kind::network || mesh.nodes[n].gateway == place.index)
      nodes.push_back(n);
  return nodes;
}

/// The nodes at which events enter the mesh at that hop.
std::vector<std::uint32_t> entries(const Situation& s, const Verdict& v, std::size_t hop) {
  const auto places = hops_of(v.route);
  const mesh::Mesh& mesh = *s.system.networks[places[hop].index].mesh;
  const Place before = hop > 0 ? places[hop - 1] : v.route.front();
  const auto& at_home = s.members.publisher(v.publisher).mesh_node;
  if (before.kind == Place::Kind::network && at_home) return {*at_home};
  return nodes_of(mesh, before);
}

/// The nodes at which events leave the mesh at that hop, or are received.
std::vector<std::uint32_t> exits(const Situation& s, const Verdict& v, std::size_t hop) {
  const auto places = hops_of(v.route);
  const mesh::Mesh& mesh = *s.system.networks[places[hop].index].mesh;
  const bool last = hop + 1 == places.size();
  const Place after = last ? v.route.back() : places[hop + 1];
  if (after.kind == Place::Kind::gateway) return nodes_of(mesh, after);
  std::vector<std::uint32_t> nodes;
  for (const std::size_t one : v.subscribers) {
    const auto& node = s.members.subscriber(one).mesh_node;
    if (!node) return nodes_of(mesh, after);
    if (std::ranges::find(nodes, *node) == nodes.end()) nodes.push_back(*node);
  }
  return nodes;
}

constexpr unsigned kAddressBits = 8;  // width of an address in can::Message::sender

}  // namespace

bool stays_at_a_node(const Situation& situation, const Verdict& verdict, std::size_t hop) {
  const auto from = entries(situation, verdict, hop);
  return from.size() == 1 && exits(situation, verdict, hop) == from;
}

Value mesh_event(const AttributeSet& offered) {
  return is_empty(offered) ? 1 : offered[Attribute::max_payload];
}

Value mesh_demand(const AttributeSet& offered, Value demand) {
  if (!is_empty(offered) || offered[Attribute::period] == 0) return demand;
  return std::max(demand, mul_div_up(1, kNanosecondsPerSecond, offered[Attribute::period]));
}

Media::Media(const Situation& situation, Ledger& ledger, std::span<Hop> hops,
             std::vector<Limit> limits, Verdict& verdict)
    : s_(situation),
      ledger_(ledger),
      places_(hops_of(verdict.route)),
      hops_(hops),
      limits_(std::move(limits)),
      v_(verdict),
      guaranteed_(hops.size(), kUnbounded) {}

bool Media::any(const Situation& situation, const Ledger& ledger, const Verdict& verdict) {
  return std::ranges::any_of(hops_of(verdict.route), [&](Place hop) {
    return hop.kind == Place::Kind::network &&
           (ledger.schedule(hop.index) != nullptr || situation.world.meshes[hop.index] != nullptr);
  });
}

Media::Kind Media::kind_of(std::size_t hop) const {
  if (places_[hop].kind != Place::Kind::network) return Kind::stated;
  const std::size_t network = places_[hop].index;
  if (ledger_.schedule(network) != nullptr) return Kind::bus;
  return s_.world.meshes[network] != nullptr ? Kind::mesh : Kind::stated;
}

void Media::take() {
  // Meshes come first, because the time that they use limits what is left for the buses.
  for (std::size_t i = 0; i < hops_.size(); ++i)
    if (kind_of(i) == Kind::mesh) take_mesh(i);
  for (std::size_t i = 0; i < hops_.size(); ++i)
    if (kind_of(i) == Kind::bus) take_bus(i);
}

void Media::obstruct(Obstacle obstacle, std::size_t hop) {
  if (v_.obstacle != Obstacle::none) return;
  v_.obstacle = obstacle;
  v_.obstacle_at = places_[hop];
}

// --- CAN buses ----------------------------------------------------------------------------------

Value Media::latency_of(std::size_t hop) const {
  if (guaranteed_[hop] != kUnbounded) return guaranteed_[hop];
  const AttributeSet& provision = hops_[hop].provision;
  const Value latency = normalised_provision(provision)[Attribute::latency];
  // A Latency that is not stated is refused for that reason. It does not reduce the time of the
  // buses.
  return latency == kUnbounded ? 0 : latency;
}

Value Media::variation_of(std::size_t hop) const {
  if (guaranteed_[hop] != kUnbounded) return guaranteed_[hop];
  const AttributeSet& provision = hops_[hop].provision;
  return provision.has(Attribute::jitter) ? provision[Attribute::jitter] : latency_of(hop);
}

Value Media::variation_before(std::size_t hop) const {
  const Publisher& publisher = s_.members.publisher(v_.publisher);
  Value sum = attributes_in(publisher, v_.set)[Attribute::jitter];
  for (std::size_t i = 0; i < hop; ++i) sum = add_saturating(sum, variation_of(i));
  return sum;
}

/// The time (ns) that the hop may take so that all subscribers there or behind get the events in
/// time. What other hops and the pauses of senders leave is shared among the buses in proportion to
/// their bit times.
/// The result does not depend on other messages of the buses, so a message is promised the same
/// time whenever it is decided. If the pauses alone exceed the limit, it is shared in proportion to
/// them.
Value Media::delay_allowed(std::size_t hop) const {
  const Publisher& publisher = s_.members.publisher(v_.publisher);
  const Value source = attributes_in(publisher, v_.set)[Attribute::jitter];
  Value most = kUnbounded;
  for (const Limit& limit : limits_) {
    if (limit.hop < hop) continue;
    Value latency = limit.latency;
    Value jitter = less(limit.jitter, source);
    const Value whole = std::min(latency, jitter);
    Value all = 0;
    Value pauses = 0;
    for (std::size_t i = 0; i <= limit.hop; ++i) {
      if (const Value weight = bit_time(i); weight != 0) {
        all += weight;
        pauses = add_saturating(pauses, pauses_at(i));
        latency = less(latency, pauses_at(i));
        jitter = less(jitter, pauses_at(i));
        continue;
      }
      const Value promised = promised_delay(i);
      latency = less(latency, std::min(latency_of(i), promised));
      jitter = less(jitter, std::min(variation_of(i), promised));
    }
    if (pauses > whole) {
      most = std::min(most, mul_div_down(whole, pauses_at(hop), pauses));
      continue;
    }
    const Value allowed = std::min(latency, jitter);
    if (allowed == kUnbounded) continue;
    const Value share = mul_div_down(allowed, bit_time(hop), all);
    most = std::min(most, add_saturating(share, pauses_at(hop)));
  }
  return most;
}

/// The weight (ns) of a bus in the sharing of time; 0 for a hop that has a delay of its own.
Value Media::bit_time(std::size_t hop) const {
  if (kind_of(hop) != Kind::bus || promised_delay(hop) != kUnbounded) return 0;
  return can::bit_time(ledger_.schedule(places_[hop].index)->assumptions().timing);
}

/// The delay (ns) that the description states for an analysed bus and that the analysis must
/// confirm; kUnbounded if none is stated.
Value Media::promised_delay(std::size_t hop) const {
  if (places_[hop].kind != Place::Kind::network) return kUnbounded;
  const AttributeSet& stated = s_.system.networks[places_[hop].index].provision;
  if (kind_of(hop) != Kind::bus || is_missing(stated, Attribute::latency)) return kUnbounded;
  const Value latency = stated[Attribute::latency];
  const Value promised = is_missing(stated, Attribute::jitter)
                             ? latency
                             : std::min(latency, stated[Attribute::jitter]);
  return add_saturating(promised, pauses_at(hop));
}

/// The longest delay (ns) that may be handed to the next bus, where it is jitter. One Period at
/// most, because a longer delay would fill the queue there; and no more than lets the jitter of a
/// route with the most hops be analysed (17 s per bus). kUnbounded if no bus follows.
Value Media::most_handed_on(std::size_t hop, const can::Message& message) const {
  for (std::size_t i = hop + 1; i < hops_.size(); ++i)
    if (kind_of(i) == Kind::bus)
      return std::min(add_saturating(message.period, message.pauses), can::kLongestTime / 64);
  return kUnbounded;
}

void Media::late_row(Place hop, const can::Schedule::Late& late) {
  Row row{.place = hop, .against = Against::schedule};
  row.end = Ledger::is_of_other(late.key)
                ? Row::kOfGateway | static_cast<std::uint32_t>(Ledger::gateway_of(late.key))
                : static_cast<std::uint32_t>(Ledger::publisher_of(late.key));
  Comparison& c = row.comparison;
  c.attribute = late.overflow ? Attribute::omission : Attribute::deadline;
  c.outcome = Outcome::unfit;
  c.known = true;
  c.required = late.overflow ? 0 : late.deadline;
  c.provided = late.overflow || !late.bounded ? kUnbounded : late.response;
  if (late.overflow) {
    row.reserved = late.queued;
    row.room = late.length;
  } else if (late.bounded && late.deadline <= late.jitter) {
    // The other hops use all of the time, so the row states the time that this hop takes.
    c.required = 0;
    c.provided = less(late.response, late.jitter);
  }
  v_.rows.push_back(row);
}

/// Subtracts the observed loads of this publisher and of those that are analysed from the
/// background of the bus, so that they do not count twice.
void Media::leave_out_own_load(std::size_t network) {
  Condition condition = s_.world.conditions[network];
  if (condition.observed.empty()) return;
  const can::Schedule& bus = *ledger_.schedule(network);
  for (const ObservedLoad& observed : condition.observed)
    if (observed.publisher == v_.publisher ||
        bus.contains(Ledger::key_of({observed.publisher, network, Flow::kOwn})))
      condition.background -= std::min(condition.background, observed.load);
  ledger_.assume(network, *bus_of(s_.system, condition, network));
}

void Media::take_bus(std::size_t hop) {
  const std::size_t network = places_[hop].index;
  leave_out_own_load(network);
  const Publisher& publisher = s_.members.publisher(v_.publisher);
  const can::Timing timing = ledger_.schedule(network)->assumptions().timing;
  auto message = can::message_of(s_.system, publisher, v_.set, network, timing);
  if (!message) {
    obstruct(Obstacle::no_period, hop);
    if (s_.tried != nullptr) s_.tried->push_back({hop, std::nullopt});
    return;
  }
  const Flow flow = flow_on(s_.system, v_.publisher, v_.route, hop);
  const std::uint64_t key = Ledger::key_of(flow);
  message->jitter = variation_before(hop);
  message->queue = sender_queue(hop);
  if (message->sender != can::kNoSender) name_sender(hop, publisher, *message);
  const Value promised = promised_delay(hop);
  Value delay = promised;
  if (promised == kUnbounded) delay = std::min(delay_allowed(hop), most_handed_on(hop, *message));
  if (const can::Message* held = ledger_.message_of(flow)) {
    // The flow is already carried to another place behind this bus: the stricter values count.
    message->jitter = std::max(message->jitter, held->jitter);
    delay = std::min(delay, less(held->deadline, held->jitter));
  }
  message->deadline = add_saturating(message->jitter, delay);
  if (s_.tried != nullptr) s_.tried->push_back({hop, message});
  const auto late = ledger_.schedule(flow, *message);
  MediumUse& use = v_.media.emplace_back();
  use.network = network;
  use.key = key;
  if (late) {
    late_row(places_[hop], *late);
    // Having been refused for the schedule, it is not refused for the late response as well.
    use.response = delay;
  } else {
    use.response = less(ledger_.schedule(network)->response(key), message->jitter);
    use.guaranteed = delay;
    guaranteed_[hop] = delay;
  }
  AttributeSet& provision = hops_[hop].provision;
  provide_response(provision, use.response);
  provide_period(provision, message->period);
  const Network& medium = s_.system.networks[network];
  provide(provision, Attribute::max_payload, event_bytes(medium, *medium.binding_of(v_.channel)));
}

void Media::renew_responses(const Situation& situation, const Ledger& ledger, Verdict& verdict) {
  const auto places = hops_of(verdict.route);
  for (MediumUse& use : verdict.media) {
    const can::Schedule* bus = ledger.schedule(use.network);
    const can::Message* message = bus != nullptr ? bus->find(use.key) : nullptr;
    if (message == nullptr) continue;
    use.response = less(bus->response(use.key), message->jitter);
    for (std::size_t i = 0; i < verdict.hops.size(); ++i) {
      if (places[i] != Place{Place::Kind::network, use.network}) continue;
      const AttributeSet& stated = situation.system.networks[use.network].provision;
      AttributeSet& provision = verdict.hops[i].provision;
      for (const Attribute a : {Attribute::latency, Attribute::jitter})
        if (is_missing(stated, a)) provision.clear(a);
      provide_response(provision, use.response);
    }
  }
}

// --- meshes -------------------------------------------------------------------------------------

/// The state of one crossing of a mesh: the request, and what its paths have provided so far.
struct Media::Crossing {
  std::size_t network;
  const mesh::Mesh& mesh;
  const MeshView& view;
  Flow flow;
  Value event;   ///< payload bytes of one event
  Value demand;  ///< bytes/s
  bool best_case;
  MediumUse use = {};
  Value available = kUnbounded;  ///< bytes/s
  Value alone = kUnbounded;      ///< bytes/s of the path alone, without any other channel
  std::size_t longest = 0;       ///< number of links of the longest path
  AttributeSet links_give = {};  ///< provision of the longest path
  bool reached = false;
  std::optional<mesh::Lack> lack = {};  ///< what the links lack that would form a path
  bool fits = true;
};

/// Handles a mesh without a path. At design time the links need not be known, and more than the
/// described ones may exist, so that it is decided at run time, unless even a path of one link
/// would be too bad.
void Media::no_path(const Crossing& c, std::size_t hop) {
  const mesh::Mesh& mesh = c.mesh;
  if (!s_.best_cases_pass || is_fixed(mesh) || mesh.nodes.empty()) {
    obstruct(obstacle_of(c.lack), hop);
    return;
  }
  if (!may_know_rates(mesh)) {
    obstruct(Obstacle::no_rate, hop);
    return;
  }
  const AttributeSet& offered = attributes_in(s_.members.publisher(v_.publisher), v_.set);
  AttributeSet& provision = hops_[hop].provision;
  provide(provision, Attribute::bandwidth, kUnbounded, true);
  provide_links(provision, mesh::best_per_hop(mesh, mesh_event(offered)), true);
  provide_events(provision, offered, true);
  // Whatever capacity is stated, nothing is carried without a path.
  Row row{.place = places_[hop], .against = Against::medium_time};
  row.comparison.attribute = Attribute::bandwidth;
  row.comparison.known = true;
  row.comparison.dynamic = true;
  row.comparison.outcome = Outcome::run_time;
  row.comparison.required = v_.demand;
  row.comparison.provided = kUnbounded;
  medium_rows_.push_back(row);
}

/// The links of the path that the flow does not use yet. A link that already carries it to another
/// place carries it once.
std::vector<std::uint32_t> Media::new_links(const Crossing& c,
                                            std::span<const std::uint32_t> path) const {
  const Holding* held = ledger_.find(c.flow);
  std::vector<std::uint32_t> more;
  for (const std::uint32_t link : path)
    if (!held->mesh || std::ranges::find(held->mesh->links, link) == held->mesh->links.end())
      more.push_back(link);
  return more;
}

/// Checks the nodes on the path; sets the obstacle and returns false if the gate of a gateway drops
/// what its node would relay.
bool Media::is_relayed(const Crossing& c, std::span<const std::uint32_t> path) {
  for (const std::uint32_t link : path.first(path.size() - 1)) {
    const std::uint32_t node = c.view.graph.links[link].to;
    if (node >= c.mesh.nodes.size()) continue;
    const auto& gateway = c.mesh.nodes[node].gateway;
    if (!gateway || relay_gate(s_.system, c.network, *gateway) == RelayGate::none) continue;
    if (v_.obstacle == Obstacle::none) {
      v_.obstacle = Obstacle::relay_gated;
      v_.obstacle_at = {Place::Kind::gateway, *gateway};
    }
    return false;
  }
  return true;
}

/// Adds one path to the crossing. Returns false if there is none or, for a best case, none that is
/// described for certain.
bool Media::take_path(Crossing& c, std::uint32_t from, std::uint32_t to) {
  if (c.best_case && mesh::is_measured(c.mesh)) return false;
  const auto& path = c.view.path(from, to);
  if (path.empty()) {
    c.lack = c.view.lack(from, to);
    return false;
  }
  if (!c.best_case && !is_relayed(c, path)) return false;
  c.reached = true;
  c.use.pairs.emplace_back(from, to);
  const mesh::PathCost& cost = c.view.cost(from, to);
  const auto background = [&](std::size_t domain) { return c.view.background[domain]; };
  c.alone = std::min(c.alone, cost.evaluate(c.event, background).available);
  if (path.size() > c.longest) {
    c.longest = path.size();
    c.links_give = mesh::composed_per_hop(c.view.graph, c.mesh, path, c.event);
  }
  const std::vector<std::uint32_t> more = new_links(c, path);
  if (more.empty()) return true;
  std::optional<mesh::PathCost> part;
  if (more.size() != path.size()) part.emplace(c.view.graph, c.mesh, c.view.domains(), more);
  const mesh::PathCost& extra = part ? *part : cost;
  const auto taken = [&](std::size_t domain) {
    return add_saturating(ledger_.medium_time(c.network, domain), c.view.background[domain]);
  };
  const auto left = extra.evaluate(c.event, taken);
  c.available = std::min(c.available, left.available);
  if (left.available < c.demand)
    c.fits = false;
  else
    ledger_.occupy(c.flow, more, extra.shares(c.demand, c.event));
  return true;
}

/// Adds the paths from each entry to each exit. Returns false if a pair of them has no path.
bool Media::take_paths(Crossing& c, std::size_t hop) {
  const std::vector<std::uint32_t> from_nodes = entries(s_, v_, hop);
  const std::vector<std::uint32_t> to_nodes = exits(s_, v_, hop);
  if (from_nodes.empty() || to_nodes.empty()) return false;
  for (const std::uint32_t from : from_nodes)
    for (const std::uint32_t to : to_nodes)
      if (from != to && !take_path(c, from, to)) return false;
  return true;
}

void Media::compare_medium_time(const Crossing& crossing, std::size_t hop) {
  Row row{.place = places_[hop], .against = Against::medium_time};
  Comparison& c = row.comparison;
  c.attribute = Attribute::bandwidth;
  c.known = true;
  c.dynamic = crossing.best_case && crossing.fits;
  c.outcome = Outcome::unfit;
  if (crossing.fits) c.outcome = crossing.best_case ? Outcome::run_time : Outcome::fit;
  c.required = crossing.demand;
  c.provided = crossing.available;
  medium_rows_.push_back(row);
}

void Media::take_mesh(std::size_t hop) {
  const std::size_t network = places_[hop].index;
  const mesh::Mesh& mesh = *s_.system.networks[network].mesh;
  const AttributeSet& offered = attributes_in(s_.members.publisher(v_.publisher), v_.set);
  Crossing c{.network = network,
             .mesh = mesh,
             .view = *s_.world.meshes[network],
             .flow = flow_on(s_.system, v_.publisher, v_.route, hop),
             .event = mesh_event(offered),
             .demand = mesh_demand(offered, v_.demand),
             .best_case = s_.best_cases_pass && !is_fixed(mesh)};
  c.use.network = network;
  if (!take_paths(c, hop)) {
    if (v_.obstacle == Obstacle::none) no_path(c, hop);
    return;
  }
  AttributeSet& provision = hops_[hop].provision;
  if (!c.reached) {
    provide_everything(provision, offered);
    return;
  }
  // If not even the path alone suffices, the smaller number is stated in a single row.
  const bool never = c.alone < c.demand;
  provide(provision, Attribute::bandwidth, never ? std::min(c.alone, c.available) : c.alone,
          c.best_case);
  provide_links(provision, c.links_give, c.best_case);
  provide_events(provision, offered, c.best_case);
  if (c.available != kUnbounded) compare_medium_time(c, hop);
  v_.media.push_back(std::move(c.use));
}

// --- senders of messages -------------------------------------------------------------------------

/// The pauses of the sender between the frames of an event, in ns; 0 if the kernel forwards the
/// frames. A stated provision is one of single frames, so the pauses are added to it.
Value Media::pauses_at(std::size_t hop) const {
  if (is_forwarded(s_.system, places_, hop)) return 0;
  const Network& network = s_.system.networks[places_[hop].index];
  const AttributeSet& offered = attributes_in(s_.members.publisher(v_.publisher), v_.set);
  return pauses_of(network, network.binding_of(v_.channel), offered[Attribute::max_payload]);
}

std::uint32_t Media::sender_queue(std::size_t hop) const {
  const Place sender = hop > 0 ? places_[hop - 1] : v_.route.front();
  if (sender.kind != Place::Kind::gateway) return can::kOwnQueue;
  return queue_of(s_.system, sender.index, places_[hop].index);
}

/// Sets the message's sender to the owner of the source address on that bus: a node, mlcca-relay, a
/// program of a user, or the bus from which the kernel forwards. In the last case the pauses are
/// already part of the jitter.
void Media::name_sender(std::size_t hop, const Publisher& publisher, can::Message& message) const {
  constexpr std::uint32_t of_user = 1U << 31U;
  std::uint32_t who = 0;
  if (is_forwarded(s_.system, places_, hop)) {
    message.pauses = 0;
    who = static_cast<std::uint32_t>(places_[hop - 2].index + 1) << kAddressBits;
  } else if (hop == 0 && publisher.place.kind == Place::Kind::gateway) {
    who = of_user | publisher.uid.value_or(0) << kAddressBits;
  }
  message.sender |= who;
}

}  // namespace mlcca::core
