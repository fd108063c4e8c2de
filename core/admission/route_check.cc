// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/route_check.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "core/admission/media.hpp"
#include "core/admission/permit_check.hpp"
#include "core/model/carrier.hpp"
#include "core/model/medium.hpp"
#include "core/model/user_values.hpp"
#include "core/profiles/profile.hpp"
#include "mlcca/arithmetic.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

/// Whether the row is about something that other flows use up as well.
bool is_about_room(const Row& row) {
  return row.against == Against::capacity || row.against == Against::schedule ||
         row.against == Against::medium_time;
}

class RouteCheck {
 public:
  RouteCheck(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
             Verdict& verdict)
      : s_(situation), ledger_(ledger), targets_(targets), v_(verdict) {}

  void run() {
    find_obstacle();
    if (!goes_on()) return;
    collect_hops();
    // Room for the rows of each hop, end to end and traffic, and the capacity of each hop.
    std::size_t asked = 0;
    for (std::size_t i = 0; i < kAttributes; ++i)
      asked += v_.requirement.has(attribute_at(i)) ? 1 : 0;
    v_.rows.reserve((count_ + 2) * asked + count_);
    const Ledger::Mark before = ledger_.mark();
    reserve();
    const std::vector<Row> medium_rows = take_media();
    check_provisions();
    check_capacities();
    v_.rows.insert(v_.rows.end(), medium_rows.begin(), medium_rows.end());
    sum_up();
    if (v_.granted) check_permits();
    if ((s_.best_cases_pass || s_.keeps_hops) && goes_on())
      v_.hops.assign(hops_.begin(), hops_.begin() + static_cast<std::ptrdiff_t>(count_));
    if (!v_.granted) ledger_.roll_back(before);
  }

  /// Renews rows and outcome after provisions of hops have changed. What was reserved on the media
  /// stays.
  void run_again() {
    count_ = v_.hops.size();
    std::ranges::copy(v_.hops, hops_.begin());
    std::vector<Row> others;
    std::ranges::copy_if(v_.rows, std::back_inserter(others), is_about_room);
    v_.rows.clear();
    at_run_time_ = std::ranges::any_of(hops(), [this](Place hop) {
      if (hop.kind != Place::Kind::network) return false;
      const Binding* const binding = s_.system.networks[hop.index].binding_of(v_.channel);
      return binding != nullptr && is_left_to_run_time(hop.index, *binding);
    });
    check_provisions();
    v_.rows.insert(v_.rows.end(), others.begin(), others.end());
    sum_up();
  }

 private:
  [[nodiscard]] bool goes_on() const {
    // A route with a second sender is checked all the same, because it may have other faults as
    // well.
    return v_.obstacle == Obstacle::none || v_.obstacle == Obstacle::sender_twice ||
           s_.tried != nullptr;
  }
  [[nodiscard]] const Publisher& publisher() const { return s_.members.publisher(v_.publisher); }
  /// What the publisher states in the attribute set being tried.
  [[nodiscard]] const AttributeSet& offered() const { return attributes_in(publisher(), v_.set); }
  [[nodiscard]] const AttributeSet& asked_by(std::size_t subscriber) const {
    return attributes_in(s_.members.subscriber(subscriber), v_.set);
  }
  [[nodiscard]] std::span<const Place> hops() const { return hops_of(v_.route); }

  void check_provisions() {
    check_hops();
    check_end_to_end();
    check_offers();
    check_overhearing();
  }

  void sum_up() {
    v_.outcome = v_.obstacle == Obstacle::none ? Outcome::fit : Outcome::unfit;
    for (const Row& row : v_.rows)
      if (!is_of_other_cases(row)) v_.outcome = worse(v_.outcome, row.comparison.outcome);
    if (at_run_time_ || v_.contested) v_.outcome = worse(v_.outcome, Outcome::run_time);
    v_.granted =
        v_.outcome == Outcome::fit || (v_.outcome == Outcome::run_time && passes_at_best());
  }

  /// Whether the row refuses a contested delivery for lack of room that it has when other best
  /// cases hold.
  [[nodiscard]] bool is_of_other_cases(const Row& row) const {
    return v_.contested && is_unfit(row) && is_about_room(row);
  }

  [[nodiscard]] bool passes_at_best() const {
    return s_.best_cases_pass && (s_.hold == nullptr || (*s_.hold)(v_));
  }

  void obstruct(Obstacle obstacle, Place at) {
    if (v_.obstacle != Obstacle::none) return;
    v_.obstacle = obstacle;
    v_.obstacle_at = at;
  }

  void find_obstacle() {
    for (const Place hop : hops())
      if (hop.kind == Place::Kind::network) find_obstacle_on(hop);
    if (s_.wish != nullptr)
      if (const auto bar = bar_on(*s_.wish, hops())) obstruct(bar->first, bar->second);
    for (std::size_t i = 1; i + 1 < v_.route.size(); ++i)
      if (v_.route[i].kind == Place::Kind::gateway) {
        if (!is_carried(i)) obstruct(Obstacle::no_sender, v_.route[i]);
        if (is_renamed(i)) obstruct(Obstacle::renamed, v_.route[i]);
      }
  }

  /// Whether the kernel would forward a multi-frame message to a bus on which the channel has
  /// another identifier; its frames name the identifier inside, which can-gw does not change.
  [[nodiscard]] bool is_renamed(std::size_t at) const {
    const Gateway& gateway = s_.system.gateways[v_.route[at].index];
    const Network& in = s_.system.networks[v_.route[at - 1].index];
    const Network& out = s_.system.networks[v_.route[at + 1].index];
    if (in.kind != NetworkKind::can || !are_joined_by_kernel(gateway, in, out)) return false;
    const Binding* const from = in.binding_of(v_.channel);
    const Binding* const to = out.binding_of(v_.channel);
    if (from == nullptr || to == nullptr) return false;
    const Value bytes = offered()[Attribute::max_payload];
    const bool transported = transport_of(in, from, bytes) != nullptr;
    if (transported != (transport_of(out, to, bytes) != nullptr)) return true;
    return transported &&
           identity_of(publisher(), in, *from, true) != identity_of(publisher(), out, *to, true);
  }

  /// Whether somebody carries the events across the gateway: the kernel, or a program whose sender
  /// is described. The gates pass no other sender.
  [[nodiscard]] bool is_carried(std::size_t at) const {
    const Gateway& gateway = s_.system.gateways[v_.route[at].index];
    const Network& in = s_.system.networks[v_.route[at - 1].index];
    const Network& out = s_.system.networks[v_.route[at + 1].index];
    if (!names_channels(in.profile) || !names_channels(out.profile) ||
        are_joined_by_kernel(gateway, in, out))
      return true;
    const Port* port = gateway.port_on(v_.route[at + 1].index);
    return port != nullptr && sender_at(gateway, *port).has_value();
  }

  void find_obstacle_on(Place hop) {
    const Network& network = s_.system.networks[hop.index];
    if (!s_.world.conditions[hop.index].available) {
      obstruct(Obstacle::unavailable, hop);
      return;
    }
    if (const EventChannel& channel = s_.system.channels[v_.channel];
        channel.unlisted && !network.unlisted.admits(channel.subject)) {
      obstruct(Obstacle::unlisted, hop);
      return;
    }
    if (!names_channels(network.profile)) return;
    if (network.carries_subjects()) {
      if (offered()[Attribute::max_payload] > event_bytes(network))
        obstruct(Obstacle::too_long, hop);
      return;
    }
    const Binding* binding = network.binding_of(v_.channel);
    if (binding == nullptr) {
      obstruct(Obstacle::unbound, hop);
      return;
    }
    // A contradiction says more than a missing tag.
    if (s_.world.conditions[hop.index].contradiction_of(v_.channel) != nullptr)
      obstruct(Obstacle::contradicted, hop);
    if (binding->waits_for_tag() && !s_.best_cases_pass) obstruct(Obstacle::untagged, hop);
    if (!can_send(publisher(), network)) obstruct(Obstacle::no_node, hop);
    if (lacks_data_rate(hop.index, *binding)) obstruct(Obstacle::no_data_rate, hop);
    if (is_left_to_run_time(hop.index, *binding)) at_run_time_ = true;
    if (offered().has(Attribute::max_payload) &&
        offered()[Attribute::max_payload] > event_bytes(network, *binding))
      obstruct(Obstacle::too_long, hop);
  }

  /// Whether FD or XL frames are impossible: the analysed bus has no bit rate for the data phase,
  /// or a gateway sets the interface up without one.
  [[nodiscard]] bool lacks_data_rate(std::size_t network, const Binding& binding) const {
    if (binding.format == FrameFormat::classic) return false;
    if (const can::Schedule* bus = ledger_.schedule(network))
      return bus->assumptions().timing.data_bitrate == 0;
    return std::ranges::any_of(s_.system.gateways, [network](const Gateway& gateway) {
      const Port* port = gateway.port_on(network);
      return port != nullptr && port->managed && port->bitrate != 0 && port->data_bitrate == 0;
    });
  }

  /// Whether only the interface will know the data bit rate, since the description states none.
  [[nodiscard]] bool waits_for_data_rate(std::size_t network, const Binding& binding) const {
    return s_.best_cases_pass && binding.format != FrameFormat::classic &&
           ledger_.schedule(network) == nullptr;
  }

  [[nodiscard]] bool is_left_to_run_time(std::size_t network, const Binding& binding) const {
    return binding.waits_for_tag() || waits_for_data_rate(network, binding);
  }

  void collect_hops() {
    const Value bytes = offered()[Attribute::max_payload];
    count_ = 0;
    for (const Place hop : hops()) {
      Hop& out = hops_[count_++];
      out.provision = s_.system.provision_of(hop);
      out.medium = static_cast<std::uint16_t>(s_.system.resource_of(hop));
      out.gateway = hop.kind == Place::Kind::gateway;
      out.frames = 1;
      if (out.gateway) continue;
      const Network& network = s_.system.networks[hop.index];
      const Binding* const binding = network.binding_of(v_.channel);
      out.frames = static_cast<std::uint16_t>(frames_per_event(network, binding, bytes));
      if (!is_forwarded(s_.system, hops(), count_ - 1))
        add_pauses(pauses_of(network, binding, bytes), ledger_.schedule(hop.index) != nullptr,
                   out.provision);
    }
  }

  /// Adds the pauses of the sender to a provision, which is one of single frames.
  static void add_pauses(Value pauses, bool analysed, AttributeSet& provision) {
    if (pauses == 0) return;
    if (!analysed && !provision.has(Attribute::latency) && provision.has(Attribute::period))
      provision.set(Attribute::latency, provision[Attribute::period],
                    provision.is_dynamic(Attribute::period));
    for (const Attribute a : {Attribute::latency, Attribute::jitter})
      if (provision.has(a))
        provision.set(a, add_saturating(provision[a], pauses), provision.is_dynamic(a));
  }

  /// An unbounded Latency counts as not provided.
  [[nodiscard]] static Comparison without_unbounded_latency(Comparison row) {
    if (held_against(row.attribute) != Attribute::latency || row.provided != kUnbounded) return row;
    row.known = false;
    row.dynamic = false;
    row.provided = 0;
    return row;
  }

  void add_rows(Against against, Place place, const CheckResult& check,
                std::size_t subscriber = 0) {
    for (std::size_t i = 0; i < check.count; ++i)
      v_.rows.push_back({.place = place,
                         .comparison = without_unbounded_latency(check.rows[i]),
                         .end = static_cast<std::uint32_t>(subscriber),
                         .against = against});
  }

  /// Adds rows for user-defined attributes.
  void add_rows(Against against, Place place, const UserValues& required,
                const UserValues& provided) {
    for (const UserValue& r : required)
      v_.rows.push_back({.place = place,
                         .comparison = compare(s_.system, r, provided),
                         .user = r.attribute,
                         .against = against});
  }

  void check_hops() {
    for (std::size_t i = 0; i < count_; ++i) {
      add_rows(Against::hop, hops()[i], check_normalised_hop(v_.requirement, hops_[i]));
      if (!v_.user_requirement.empty())
        add_rows(Against::hop, hops()[i], asked_of(i), user_provision(i, 1));
    }
  }

  /// What is required of one hop. A gateway is not asked for attributes that it does not state and
  /// does not limit.
  [[nodiscard]] UserValues asked_of(std::size_t hop) const {
    UserValues asked = v_.user_requirement;
    if (hops_[hop].gateway) {
      const UserValues gives = user_provision(hop, 1);
      const auto& own = s_.system.gateways[hops()[hop].index].user;
      std::erase_if(asked, [&](const UserValue& v) {
        const auto same = [&](const UserValue& o) { return o.attribute == v.attribute; };
        return std::ranges::none_of(own, same) && std::ranges::any_of(gives, same);
      });
    }
    return asked;
  }

  /// The composed user-defined provision of `count` hops from the first on.
  [[nodiscard]] UserValues user_provision(std::size_t first, std::size_t count) const {
    std::array<UserHop, kMaxHops> out;
    for (std::size_t i = 0; i < count; ++i) {
      const Place hop = hops()[first + i];
      const bool gateway = hop.kind == Place::Kind::gateway;
      out[i] = {gateway ? &s_.system.gateways[hop.index].user : &s_.system.networks[hop.index].user,
                gateway, hops_[first + i].frames};
    }
    return core::composed(s_.system, std::span(out).first(count));
  }

  /// The composed provision of the first `count` hops.
  [[nodiscard]] AttributeSet composed(std::size_t count) const {
    return compose(hops_.data(), count, offered()[Attribute::jitter]);
  }

  void check_end_to_end() {
    v_.provision = composed(count_);
    if (count_ == 0) return;  // publisher and subscriber on one host: no network in between
    add_rows(Against::end_to_end, v_.to, check_normalised_layer(v_.requirement, v_.provision));
    if (!v_.user_requirement.empty())
      add_rows(Against::end_to_end, v_.to, v_.user_requirement, user_provision(0, count_));
  }

  void check_offers() {
    for (const std::size_t s : v_.subscribers)
      add_rows(Against::traffic, v_.to, check_traffic(offered(), asked_by(s)), s);
  }

  /// Every subscriber on a broadcast medium receives an event that crosses it, so the route is
  /// granted only if each of them is fulfilled too. On the publisher's own network they receive it
  /// in any case.
  void check_overhearing() {
    each_overhearing_subscriber([this](const Target& target, std::size_t hop) {
      check_overhearing_subscriber(target, hop);
    });
  }

  template <class Then>
  void each_overhearing_subscriber(const Then& then) const {
    const bool at_home = publisher().place.kind == Place::Kind::network;
    for (std::size_t i = at_home ? 1 : 0; i < count_; ++i)
      if (hops()[i].kind == Place::Kind::network)
        for (const Target& target : targets_)
          if (target.place != v_.to && receives(target.place, i)) then(target, i);
  }

  /// Whether a subscriber at that place receives what crosses the network of that hop first: it is
  /// on that network, or it is a program on a gateway with a port there that the route has not
  /// passed before.
  [[nodiscard]] bool receives(Place listener, std::size_t hop) const {
    const Place network = hops()[hop];
    if (listener.kind == Place::Kind::network) return listener == network;
    if (s_.system.gateways[listener.index].port_on(network.index) == nullptr) return false;
    const auto before = std::ranges::find(v_.route, network);
    return std::find(v_.route.begin(), before, listener) == before;
  }

  void check_overhearing_subscriber(const Target& target, std::size_t hop) {
    const Place place = hops()[hop];
    const JointRequirements asked = asked_together(s_, v_.publisher, target.subscribers, v_.set);
    add_rows(Against::overhearing, place, check_normalised_layer(asked.set, composed(hop + 1)));
    if (!asked.user.empty())
      add_rows(Against::overhearing, place, asked.user, user_provision(0, hop + 1));
    for (const std::size_t s : target.subscribers)
      add_rows(Against::traffic, place, check_traffic(offered(), asked_by(s)), s);
  }

  /// Adds the flow to the ledger on each hop where it is not carried yet, and remembers for the
  /// rows what is promised to others.
  void reserve() {
    known_ = demand_of(offered(), &v_.demand);
    if (!known_) v_.demand = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      // A gateway without a stated rate has no capacity to share.
      if (hops_[i].gateway && !hops_[i].provision.has(Attribute::bandwidth)) continue;
      const Flow flow = flow_on(s_.system, v_.publisher, v_.route, i);
      reserved_[i] = ledger_.reserved_without(flow);
      // A demand that does not fit is refused below. It must not overflow the sum before that.
      fresh_[i] = ledger_.add(flow, std::min(v_.demand, kUnbounded - reserved_[i]));
    }
  }

  /// Whether the hop is a mesh whose medium time is reserved, in place of its stated best case.
  [[nodiscard]] bool is_evaluated(Place hop) const {
    return hop.kind == Place::Kind::network && s_.world.meshes[hop.index] != nullptr;
  }

  std::vector<Row> take_media() {
    if (!Media::any(s_, ledger_, v_)) return {};
    for (std::size_t i = 0; i < count_ && !known_; ++i)
      if (is_evaluated(hops()[i])) {
        obstruct(Obstacle::no_traffic, hops()[i]);
        return {};
      }
    Media media(s_, ledger_, std::span(hops_).first(count_), limits(), v_);
    media.take();
    return media.take_medium_rows();
  }

  /// The last check of a granted delivery: what it needs of shared networks must be promised or
  /// reserved, and other gateways must carry it.
  void check_permits() {
    const auto hop = unpermitted(s_, ledger_, v_);
    const auto why = hop ? std::optional(std::pair(Obstacle::cluster, *hop)) : disagreement(s_, v_);
    if (!why) return;
    obstruct(why->first, why->second);
    sum_up();
    if (s_.wished != nullptr) s_.wished->insert(v_.channel);
  }

  /// The time limits of all subscribers that receive the events, overhearing ones included.
  [[nodiscard]] std::vector<Limit> limits() const {
    std::vector<Limit> all{limit_at(count_ - 1, v_.requirement)};
    each_overhearing_subscriber([&](const Target& target, std::size_t hop) {
      all.push_back(
          limit_at(hop, asked_together(s_, v_.publisher, target.subscribers, v_.set).set));
    });
    return all;
  }
  [[nodiscard]] static Limit limit_at(std::size_t hop, const AttributeSet& asked) {
    Limit limit{hop, kUnbounded, kUnbounded};
    for (const Attribute a : {Attribute::deadline, Attribute::latency})
      if (asked.has(a)) limit.latency = std::min(limit.latency, asked[a]);
    if (asked.has(Attribute::jitter)) limit.jitter = asked[Attribute::jitter];
    return limit;
  }

  /// Whether the hop's bandwidth is a best case, so that what is already carried for another place
  /// is checked again.
  [[nodiscard]] bool is_carried_at_best(Place hop) const {
    return s_.best_cases_pass && s_.system.provision_of(hop).is_dynamic(Attribute::bandwidth);
  }

  void check_capacities() {
    for (std::size_t i = 0; i < count_; ++i) {
      const Place hop = hops()[i];
      if (!fresh_[i] && !is_carried_at_best(hop)) continue;
      const CapacityCheck c = check_capacity(s_.system.provision_of(hop), reserved_[i], v_.demand);
      if (!c.known || (c.outcome == Outcome::run_time && is_evaluated(hop))) continue;
      if (!known_) {
        obstruct(Obstacle::no_traffic, hop);
        return;
      }
      Row row{.place = hop, .reserved = reserved_[i], .against = Against::capacity};
      row.comparison.attribute = Attribute::bandwidth;
      row.comparison.outcome = c.outcome;
      row.comparison.known = true;
      row.comparison.dynamic = c.outcome == Outcome::run_time;
      row.comparison.required = c.demand;
      row.comparison.provided = c.capacity > reserved_[i] ? c.capacity - reserved_[i] : 0;
      v_.rows.push_back(row);
    }
  }

  const Situation& s_;
  Ledger& ledger_;
  const std::vector<Target>& targets_;
  Verdict& v_;
  std::array<Hop, kMaxHops> hops_{};
  std::array<Value, kMaxHops> reserved_{};  ///< bytes/s promised to others, per hop
  std::array<bool, kMaxHops> fresh_{};      ///< per hop: newly reserved, not already carried for
                                            ///< another place
  bool known_ = false;                      ///< the publisher states its traffic
  std::size_t count_ = 0;
  bool at_run_time_ = false;  ///< a tag or data bit rate on the route is still unknown
};

}  // namespace

Flow flow_on(const System& system, std::size_t publisher, const Route& route, std::size_t hop) {
  const auto hops = hops_of(route);
  Flow flow{publisher, system.resource_of(hops[hop])};
  // The publisher's own gateway is not a hop, but the traffic comes from there.
  if (hop > 0)
    flow.from = system.resource_of(hops[hop - 1]);
  else if (route.front() != hops.front())
    flow.from = system.resource_of(route.front());
  return flow;
}

void check_route(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
                 Verdict& verdict) {
  RouteCheck(situation, ledger, targets, verdict).run();
}

void renew_responses(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
                     Verdict& verdict) {
  if (!verdict.granted || verdict.media.empty() || verdict.hops.empty()) return;
  Media::renew_responses(situation, ledger, verdict);
  RouteCheck(situation, ledger, targets, verdict).run_again();
}

}  // namespace mlcca::core
