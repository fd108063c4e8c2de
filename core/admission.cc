// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "core/medium.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

/// What a publisher and all of these subscribers together ask of the networks between them.
AttributeSet union_of(const Members& members, std::size_t publisher,
                      const std::vector<std::size_t>& subscribers) {
  const AttributeSet& offered = members.publisher(publisher).attributes;
  AttributeSet requirement = requirement_between(offered, {});
  for (const std::size_t s : subscribers)
    requirement =
        strictest(requirement, requirement_between(offered, members.subscriber(s).attributes));
  return requirement;
}

/// Subscribers of a channel at one place.
struct Target {
  Place place;
  std::vector<std::size_t> subscribers;
};

std::vector<Target> targets_of(const Members& members, std::size_t channel) {
  std::vector<Target> targets;
  for (const std::size_t s : members.subscribers_of(channel)) {
    const Place place = members.subscriber(s).place;
    auto it = std::ranges::find(targets, place, &Target::place);
    if (it == targets.end()) it = targets.insert(targets.end(), {place, {}});
    it->subscribers.push_back(s);
  }
  return targets;
}

/// Decides one publisher towards one target, over one route.
class RouteCheck {
 public:
  RouteCheck(const Situation& situation, const Ledger& ledger, const std::vector<Target>& targets,
             Verdict& verdict)
      : s_(situation), ledger_(ledger), targets_(targets), v_(verdict) {}

  void run() {
    find_obstacle();
    if (v_.obstacle != Obstacle::none) return;
    collect_hops();
    check_hops();
    check_end_to_end();
    check_offers();
    check_bystanders();
    check_capacities();
    v_.granted = v_.obstacle == Obstacle::none && std::ranges::all_of(v_.rows, [](const Row& row) {
                   return at_run_time(row.comparison.outcome) == Outcome::fit;
                 });
  }

 private:
  [[nodiscard]] const Publisher& publisher() const { return s_.members.publisher(v_.publisher); }
  [[nodiscard]] std::span<const Place> hops() const { return hops_of(v_.route); }

  void obstruct(Obstacle obstacle, Place at) {
    if (v_.obstacle != Obstacle::none) return;
    v_.obstacle = obstacle;
    v_.obstacle_at = at;
  }

  void find_obstacle() {
    for (const Place hop : hops())
      if (hop.kind == Place::Kind::network) find_obstacle_on(hop);
  }

  void find_obstacle_on(Place hop) {
    const Network& network = s_.system.networks[hop.index];
    if (!s_.conditions[hop.index].available) {
      obstruct(Obstacle::unavailable, hop);
      return;
    }
    if (network.profile == Profile::none) return;
    const Binding* binding = network.binding_of(v_.channel);
    if (binding == nullptr) {
      obstruct(Obstacle::unbound, hop);
      return;
    }
    if (network.profile == Profile::famouso) {
      if (!publisher().node) obstruct(Obstacle::no_node, hop);
    } else if (publisher().attributes.has(Attribute::max_payload) &&
               publisher().attributes[Attribute::max_payload] > frame_bytes(*binding)) {
      obstruct(Obstacle::too_long, hop);
    }
  }

  void collect_hops() {
    const auto& attributes = publisher().attributes;
    const Value bytes = attributes[Attribute::max_payload];
    count_ = 0;
    for (const Place hop : hops()) {
      Hop& out = hops_[count_++];
      if (hop.kind == Place::Kind::gateway) {
        out.provision = s_.system.gateways[hop.index].provision;
        out.medium = static_cast<std::uint16_t>(s_.system.networks.size() + hop.index);
        out.frames = 1;
      } else {
        const Network& network = s_.system.networks[hop.index];
        out.provision = network.provision;
        out.medium = static_cast<std::uint16_t>(hop.index);
        out.frames = static_cast<std::uint16_t>(
            frames_per_event(network, network.binding_of(v_.channel), bytes));
      }
    }
  }

  void add_rows(Against against, Place place, const Check& check, std::size_t subscriber = 0) {
    for (std::size_t i = 0; i < check.count; ++i)
      v_.rows.push_back({against, place, subscriber, check.rows[i], 0});
  }

  /// What the hop provides for events of this size: per-frame loss and omission become per-event
  /// ones. A gateway states no rate of its own unless it does.
  void check_hops() {
    for (std::size_t i = 0; i < count_; ++i)
      add_rows(Against::hop, hops()[i], check_hop(v_.requirement, hops_[i], hops()[i]));
  }

  [[nodiscard]] static Check check_hop(const AttributeSet& requirement, const Hop& hop,
                                       Place place) {
    AttributeSet asked = requirement;
    if (place.kind == Place::Kind::gateway) drop_unstated_limits(asked, hop.provision);
    if (hop.frames == 1) return check_layer(asked, hop.provision);
    return check_layer(asked, compose(&hop, 1));
  }

  /// A gateway is no medium: it limits rate, period or size only where it says so.
  static void drop_unstated_limits(AttributeSet& asked, const AttributeSet& provision) {
    for (const Attribute a : {Attribute::bandwidth, Attribute::max_payload, Attribute::period})
      if (!provision.has(a)) asked.clear(a);
  }

  /// The composed provision of the first `count` hops.
  [[nodiscard]] AttributeSet composed(std::size_t count) const {
    std::array<Hop, kMaxHops> filled;
    for (std::size_t i = 0; i < count; ++i) {
      filled[i] = hops_[i];
      if (hops()[i].kind == Place::Kind::gateway) state_no_limit(filled[i].provision);
    }
    const Value jitter = publisher().attributes[Attribute::jitter];
    return compose(filled.data(), count, jitter);
  }

  static void state_no_limit(AttributeSet& provision) {
    if (!provision.has(Attribute::bandwidth)) provision.set(Attribute::bandwidth, kUnbounded);
    if (!provision.has(Attribute::max_payload)) provision.set(Attribute::max_payload, kUnbounded);
    if (!provision.has(Attribute::period)) {
      // A gateway that states no latency must not be given one by the period we fill in.
      const bool latency = provision.has(Attribute::latency);
      provision.set(Attribute::period, 0);
      if (!latency) provision.set(Attribute::latency, kUnbounded);
    }
  }

  void check_end_to_end() {
    v_.provision = composed(count_);
    if (count_ == 0) return;  // publisher and subscriber on one host: no network in between
    add_rows(Against::end_to_end, v_.to, check_layer(v_.requirement, v_.provision));
  }

  void check_offers() {
    for (const std::size_t s : v_.subscribers)
      add_rows(Against::traffic, v_.to,
               check_traffic(publisher().attributes, s_.members.subscriber(s).attributes), s);
  }

  /// An event that crosses a broadcast medium is heard by every subscriber there: the way is open
  /// only if each of them is fulfilled too. The first network is the publisher's own: there the
  /// event is, whatever we decide.
  void check_bystanders() {
    for (std::size_t i = 1; i + 1 < count_; ++i) {
      const auto target = std::ranges::find(targets_, hops()[i], &Target::place);
      if (target == targets_.end()) continue;
      const AttributeSet requirement = union_of(s_.members, v_.publisher, target->subscribers);
      add_rows(Against::bystander, hops()[i], check_layer(requirement, composed(i + 1)));
      for (const std::size_t s : target->subscribers)
        add_rows(Against::traffic, hops()[i],
                 check_traffic(publisher().attributes, s_.members.subscriber(s).attributes), s);
    }
  }

  void check_capacities() {
    Value demand = 0;
    const bool known = demand_of(publisher().attributes, &demand);
    v_.demand = known ? demand : 0;
    for (const Place hop : hops()) {
      if (hop.kind != Place::Kind::network) continue;
      if (ledger_.carries({v_.publisher, hop.index})) continue;
      const Value reserved = ledger_.reserved(hop.index);
      const CapacityCheck c =
          check_capacity(s_.system.networks[hop.index].provision, reserved, v_.demand);
      if (!c.known) continue;
      if (!known) {
        obstruct(Obstacle::no_traffic, hop);
        return;
      }
      Row row{Against::capacity, hop, 0, {}, reserved};
      row.comparison.attribute = Attribute::bandwidth;
      row.comparison.outcome = c.outcome;
      row.comparison.known = true;
      row.comparison.dynamic = c.outcome == Outcome::run_time;
      row.comparison.required = c.demand;
      row.comparison.provided = c.capacity > reserved ? c.capacity - reserved : 0;
      v_.rows.push_back(row);
    }
  }

  const Situation& s_;
  const Ledger& ledger_;
  const std::vector<Target>& targets_;
  Verdict& v_;
  std::array<Hop, kMaxHops> hops_{};
  std::size_t count_ = 0;
};

Verdict blank(const Situation& s, std::size_t channel, std::size_t publisher,
              const Target& target) {
  Verdict v;
  v.channel = channel;
  v.publisher = publisher;
  v.to = target.place;
  v.subscribers = target.subscribers;
  v.requirement = normalised_requirement(union_of(s.members, publisher, target.subscribers));
  return v;
}

Verdict decide_one(const Situation& s, const Ledger& ledger, const std::vector<Target>& targets,
                   std::size_t channel, std::size_t publisher, const Target& target) {
  Verdict first = blank(s, channel, publisher, target);
  if (s.released[channel]) {
    first.obstacle = Obstacle::released;
    return first;
  }
  const auto& routes = s.topology.routes(s.members.publisher(publisher).place, target.place);
  if (routes.empty()) {
    first.obstacle = Obstacle::no_route;
    return first;
  }
  const Verdict start = routes.size() > 1 ? first : Verdict{};
  first.route = routes.front();
  RouteCheck(s, ledger, targets, first).run();
  for (std::size_t i = 1; i < routes.size() && !first.granted; ++i) {
    Verdict other = start;
    other.route = routes[i];
    RouteCheck(s, ledger, targets, other).run();
    if (other.granted) return other;
  }
  return first;
}

void decide_into(const Situation& s, std::size_t channel, LedgerBuilder& builder,
                 std::vector<Verdict>& verdicts) {
  const std::vector<Target> targets = targets_of(s.members, channel);
  for (const std::size_t publisher : s.members.publishers_of(channel)) {
    for (const Target& target : targets) {
      Verdict v = decide_one(s, builder.ledger(), targets, channel, publisher, target);
      if (v.granted)
        for (const Place hop : hops_of(v.route))
          if (hop.kind == Place::Kind::network) builder.add({publisher, hop.index}, v.demand);
      verdicts.push_back(std::move(v));
    }
  }
}

}  // namespace

ChannelDecision decide(const Situation& situation, std::size_t channel, const Ledger& before) {
  LedgerBuilder builder(before);
  std::vector<Verdict> verdicts;
  decide_into(situation, channel, builder, verdicts);
  return {std::move(verdicts), std::move(builder).take()};
}

Decision decide_all(const Situation& situation) {
  LedgerBuilder builder(Ledger(situation.system.networks.size()));
  Decision decision;
  decision.channels.resize(situation.system.channels.size());
  for (std::size_t c = 0; c < decision.channels.size(); ++c)
    decide_into(situation, c, builder, decision.channels[c]);
  decision.ledger = std::move(builder).take();
  return decision;
}

}  // namespace mlcca::core
