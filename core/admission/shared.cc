// SPDX-License-Identifier: BSD-2-Clause
// The part of the state that has to do with other gateways: what they hold, what this one may hold,
// and what it would have to ask for.
#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "core/admission/permit_check.hpp"
#include "core/admission/route_check.hpp"
#include "core/admission/state.hpp"
#include "core/can/cover.hpp"
#include "core/can/level.hpp"

namespace mlcca::core {
namespace {

/// What a flow is promised for one reason or several.
struct Promise {
  Value bytes_per_second = 0;
  std::optional<can::Message> message;
  std::vector<cluster::PathPart> paths;
  bool by_others = false;

  void take(Value bytes) { bytes_per_second = std::max(bytes_per_second, bytes); }
  void take(can::Message m) {
    m.key = 0;
    message = message ? can::strictest(*message, m) : m;
  }
  void take(const cluster::PathPart& path) { join(paths, path); }
};

/// The promises of a network, put together.
class Promises {
 public:
  /// `self`: the gateway in whose numbers admissions are those of this state; nothing: none is.
  Promises(const System& system, const Members& members, std::size_t network,
           std::optional<std::size_t> self)
      : system_(system), members_(members), network_(network), self_(self) {}

  void take(const cluster::Standing& standing) {
    Promise& promise = all_[standing.flow];
    promise.take(standing.bytes_per_second);
    if (standing.message) promise.take(*standing.message);
    for (const cluster::PathPart& path : standing.paths) promise.take(path);
  }
  void take(const cluster::Part& part) { take_all(part, false); }
  /// Of what others hold: the traffic of publishers that are there.
  void take(const cluster::Foreign& foreign) { take_all(foreign, true); }

  [[nodiscard]] const std::map<Flow, Promise>& all() const { return all_; }
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  template <class Parts>
  void take_all(const Parts& parts, bool by_others) {
    constexpr Value too_much = Value{1} << 44U;  // and little enough that sums do not overflow
    for (const cluster::RatePart& rate : parts.rates)
      if (Promise* const promise = of(rate, by_others))
        promise->take(std::min(rate.bytes_per_second, too_much));
    for (const cluster::BusPart& bus : parts.bus)
      if (Promise* const promise = of(bus, by_others)) promise->take(bus.message);
    for (const cluster::PathPart& path : parts.paths)
      if (Promise* const promise = of(path, by_others)) promise->take(path);
  }

  /// Null where the publisher is not there.
  template <class Part>
  Promise* of(const Part& part, bool by_others) {
    const cluster::Source& source = part.source;
    std::size_t publisher = source.publisher;
    if (source.admission != 0) {
      if (by_others && part.gateway != self_) return nullptr;  // see core::others_on()
      const auto admitted = members_.admitted(source.admission).publisher;
      if (!admitted) return nullptr;
      publisher = *admitted;
    } else if (publisher >= system_.publishers.size()) {
      complete_ = false;
      return nullptr;
    }
    Promise& promise = all_[{publisher, network_, source.from}];
    promise.by_others = promise.by_others || by_others;
    return &promise;
  }

  const System& system_;
  const Members& members_;
  std::size_t network_;
  std::optional<std::size_t> self_;
  std::map<Flow, Promise> all_;
  bool complete_ = true;
};

/// What gateways count together cannot be counted there.
bool is_uncountable(const Network& network, bool analysed, bool evaluated) {
  if (network.kind == NetworkKind::can && network.profile != Profile::none)
    return !analysed || network.bus.bitrate == 0;
  return network.mesh.has_value() && (network.mesh->nodes.empty() || !evaluated);
}

/// The gateway that puts the flow on the network; nothing where its publisher is there itself.
std::optional<std::size_t> sender_of(const System& system, const Flow& flow) {
  if (flow.from == Flow::kOwn || flow.from < system.networks.size()) return std::nullopt;
  return flow.from - system.networks.size();
}

/// It is promised for a gateway that has failed, and another one carries it in its place.
bool is_replaced(const System& system, const World& world, const cluster::Standing& standing) {
  const auto sender = sender_of(system, standing.flow);
  return standing.elected && sender && world.failed[*sender];
}

/// A network as it is now.
struct Medium {
  std::optional<can::Assumptions> bus;
  const mesh::Mesh* mesh = nullptr;
  const MeshView* view = nullptr;
};

/// `complete`: false from now on if not all of the promise can be counted.
Placeholder placeholder_of(const Flow& flow, const Promise& promise, const Medium& medium,
                           bool& complete) {
  Placeholder p;
  p.flow = flow;
  p.bytes_per_second = promise.bytes_per_second;
  p.by_others = promise.by_others;
  if (promise.message && medium.bus && can::usable(*medium.bus, *promise.message))
    p.message = promise.message;
  complete = complete && promise.message.has_value() == p.message.has_value();
  if (promise.paths.empty()) return p;
  auto shares = medium.mesh == nullptr || medium.view == nullptr
                    ? std::nullopt
                    : shares_of_joined(*medium.mesh, *medium.view, promise.paths);
  complete = complete && shares;
  if (shares) p.shares = std::move(*shares);
  return p;
}

void note_shared(const World& world, const Route& route, std::set<std::size_t>& networks) {
  for (const Place hop : hops_of(route))
    if (hop.kind == Place::Kind::network && world.shared[hop.index]) networks.insert(hop.index);
}

/// Of what gateways hold of a mesh: what they have in the domains that the verdict needs.
std::vector<HeldBy> held_on_way(std::span<const HeldBy> held, const Verdict& v, std::size_t network,
                                const MeshView* view) {
  std::set<std::uint32_t> needed;
  for (const MediumUse& use : v.media)
    for (const auto& [from, to] : use.pairs)
      if (use.network == network && view != nullptr)
        for (const std::uint32_t link : view->path(from, to)) {
          const auto& here = view->domains().of_link(link);
          needed.insert(here.begin(), here.end());
        }
  std::vector<HeldBy> there;
  for (const HeldBy& one : held) {
    HeldBy part = one;
    std::erase_if(part.shares,
                  [&](const mesh::Share& share) { return !needed.contains(share.domain); });
    if (!part.shares.empty()) there.push_back(std::move(part));
  }
  return there;
}

/// Networks of several gateways on the ways that deliveries of the channel may take.
std::set<std::size_t> shared_ways(const Situation& s, std::size_t channel) {
  std::set<std::size_t> networks;
  for (const std::size_t p : s.members.publishers_of(channel))
    for (const Target& target : targets_of(s.members, channel))
      for (const Route& route : s.topology.routes(s.members.publisher(p).place, target.place))
        note_shared(s.world, route, networks);
  return networks;
}

}  // namespace

void State::set_foreign(std::size_t network, cluster::Foreign foreign) {
  held_.erase(network);
  if (foreign == world_.foreign[network]) return;
  world_.foreign[network] = std::move(foreign);
  note_own_there(network);
  others_stale_.insert(network);
}

/// In numbers of this gateway: see note_reservations().
void State::note_own_there(std::size_t network) {
  own_there_[network] = permits_ != nullptr &&
                        std::ranges::any_of(world_.foreign[network].rates, [&](const auto& rate) {
                          return rate.gateway == permits_->self();
                        });
}

void State::set_permits(const Permits* permits) {
  if (permits == permits_) return;
  permits_ = permits;
  seen_grown_.assign(system_.networks.size(), 0);
  seen_shrunk_.assign(system_.networks.size(), 0);
  seen_more_agreed_ = seen_less_agreed_ = 0;
  world_.elects = permits != nullptr;
  wished_.clear();
  for (std::size_t n = 0; n < system_.networks.size(); ++n) {
    note_own_there(n);
    if (world_.shared[n]) others_stale_.insert(n);
  }
  invalidate_all();
}

void State::share_all(std::size_t gateway) {
  for (const Port& port : system_.gateways[gateway].ports) world_.shared[port.network] = true;
}

bool State::are_permits_seen() const {
  if (permits_ == nullptr) return true;
  for (std::size_t n = 0; n < system_.networks.size(); ++n)
    if (permits_->grown(n) != seen_grown_[n] || permits_->shrunk(n) != seen_shrunk_[n])
      return false;
  return permits_->more_agreed() == seen_more_agreed_ &&
         permits_->less_agreed() == seen_less_agreed_;
}

/// What may not be held any more is decided again, and so is what could be given more.
void State::note_permits() {
  if (permits_ == nullptr) return;
  bool grown = false;
  for (std::size_t n = 0; n < system_.networks.size(); ++n) {
    const bool more = std::exchange(seen_grown_[n], permits_->grown(n)) != permits_->grown(n);
    const std::uint64_t before = std::exchange(seen_shrunk_[n], permits_->shrunk(n));
    const bool less = before != permits_->shrunk(n);
    if (more || less) others_stale_.insert(n);
    grown = grown || more;
    if (less) touch_ended(n, before);
  }
  if (const std::uint64_t before = std::exchange(seen_less_agreed_, permits_->less_agreed());
      before != seen_less_agreed_)
    touch_disagreed(before);
  const std::uint64_t agreed = std::exchange(seen_more_agreed_, permits_->more_agreed());
  if (!grown && agreed == seen_more_agreed_) return;
  std::ranges::copy_if(wished_, std::inserter(touched_, touched_.end()), [this](std::size_t c) {
    return !is_best(c) || usage_.detours().contains(c);
  });
}

/// Nothing is better than what the channel is given, but for the ways.
bool State::is_best(std::size_t channel) const {
  const Decision& now = decisions_[channel];
  return now.set == 0 && now.granted != 0 && now.all_granted();
}

/// Channels that may be given less of the network than when that had not ended.
void State::touch_ended(std::size_t network, std::uint64_t shrunk) {
  const auto& carried = usage_.carried_by(network);
  const auto ended = permits_->ended_since(network, shrunk);
  if (!ended || !ledger_.counts_all(network)) {
    touched_.insert(carried.begin(), carried.end());
    return;
  }
  for (const cluster::Source& source : *ended) {
    const auto publisher = source.admission == 0 ? std::optional(source.publisher)
                                                 : members_.admitted(source.admission).publisher;
    if (!publisher || (source.admission == 0 && *publisher >= system_.publishers.size())) continue;
    const std::size_t channel = members_.publisher(*publisher).channel;
    if (carried.contains(channel)) touched_.insert(channel);
  }
  touch_detours(network);
}

/// Channels of which another gateway may carry less. All of its way leads over shared networks.
void State::touch_disagreed(std::uint64_t less_agreed) {
  const auto admissions = permits_->disagreed_since(less_agreed);
  for (const AdmissionId id : admissions.value_or(std::span<const AdmissionId>()))
    if (const auto known = admissions_.find(id); known != admissions_.end())
      touched_.insert(known->second);
  for (std::size_t n = 0; !admissions && n < system_.networks.size(); ++n)
    if (world_.shared[n]) touched_.insert(usage_.carried_by(n).begin(), usage_.carried_by(n).end());
}

/// Which way a delivery takes does not depend on the past where gateways are elected. So one that
/// does not take its first way is decided again with whatever changes here.
void State::touch_detours(std::size_t network) {
  const auto& carried = usage_.carried_by(network);
  for (const std::size_t c : usage_.detours())
    if (carried.contains(c)) touched_.insert(c);
}

/// The publisher of the admission comes or goes, and with it the flows that they are of.
void State::note_reservations(AdmissionId id) {
  if (permits_ == nullptr) return;
  for (std::size_t n = 0; n < system_.networks.size(); ++n)
    if (own_there_[n] || permits_->has_reserved(n, id)) others_stale_.insert(n);
}

Others State::others_on(std::size_t network, const MeshView* view) const {
  const auto self = permits_ != nullptr ? std::optional(permits_->self()) : std::nullopt;
  const CountsWithPublisher counts = [&](std::size_t gateway, const cluster::Source& source) {
    return gateway == self && members_.admitted(source.admission).publisher.has_value();
  };
  Others others = core::others_on(system_, world_, network, view, counts);
  Promises promises(system_, members_, network, self);
  promises.take(world_.foreign[network]);
  if (permits_ != nullptr) {
    for (const cluster::Standing& standing : permits_->standing(network))
      if (!is_replaced(system_, world_, standing)) promises.take(standing);
    for (const auto& [number, part] : permits_->reserved(network)) promises.take(part);
  }
  others.complete = others.complete && promises.complete();
  const Medium medium{
      .bus = bus_of(system_, world_.conditions[network], network),
      .mesh = system_.networks[network].mesh ? &*system_.networks[network].mesh : nullptr,
      .view = view};
  for (const auto& [flow, promise] : promises.all())
    others.standing.push_back(placeholder_of(flow, promise, medium, others.complete));
  return others;
}

/// Networks of which nothing can be reserved for a channel now.
std::map<std::size_t, Obstacle> State::barred_to_wishes(std::size_t channel) {
  std::map<std::size_t, Obstacle> barred;
  for (const std::size_t n : shared_ways(situation(), channel)) {
    const bool known = others_complete_.empty() || others_complete_[n];
    if (!known || is_uncountable(system_.networks[n], ledger_.schedule(n) != nullptr,
                                 world_.meshes[n] != nullptr))
      barred.emplace(n, Obstacle::others_unknown);
    else if (!ledger_.raise(n))
      barred.emplace(n, Obstacle::crowded);
  }
  return barred;
}

const std::vector<HeldBy>& State::held_by_others(std::size_t network) const {
  static const std::vector<HeldBy> nobody;
  if (holdings_ == nullptr || !world_.shared[network]) return nobody;
  const auto& view = world_.meshes[network];
  const auto known = held_.find(network);
  if (known != held_.end() && known->second.view == view) return known->second.by;
  Held held{view, held_by(system_, world_, network, holdings_->of_others(network))};
  const auto made_for = holdings_->made_for(network);
  for (HeldBy& one : held.by)
    if (const auto others = made_for.find(one.gateway); others != made_for.end())
      one.made_for = others->second;
  return held_.insert_or_assign(network, std::move(held)).first->second.by;
}

std::string State::excess_of_others(std::size_t network) const {
  // What is cheap to know comes first.
  const auto& view = world_.meshes[network];
  const AttributeSet& provision = system_.networks[network].provision;
  bool full = provision.has(Attribute::bandwidth) &&
              ledger_.reserved(network) > provision[Attribute::bandwidth];
  if (const can::Schedule* const bus = ledger_.schedule(network))
    full = full || bus->spares_any() || !bus->late().empty();
  for (std::size_t d = 0; !full && view && d < view->domains().count(); ++d)
    full = ledger_.medium_time(network, d) > mesh::limit_of(*system_.networks[network].mesh);
  return full ? excess_words(system_, world_, network, held_by_others(network)) : std::string();
}

/// Why it is not known what others hold.
std::string State::why_others_unknown(std::size_t network) const {
  if (const std::string words = holdings_->unreadable(network); !words.empty()) return ": " + words;
  const std::string words = uncountable_words(system_, held_by_others(network));
  return words.empty()
             ? words
             : ": reservations cannot be counted with the network as it is now, those of " + words;
}

std::string State::who_holds(const Verdict& v) const {
  if (v.granted || holdings_ == nullptr) return {};
  std::vector<HeldBy> held;
  Place at = v.obstacle_at;
  if (v.obstacle == Obstacle::others_unknown) return why_others_unknown(at.index);
  if (v.obstacle == Obstacle::crowded) {
    held = held_by_others(at.index);
  } else if (const Row* const row = v.obstacle == Obstacle::none ? deciding_row(v) : nullptr;
             row != nullptr && row->place.kind == Place::Kind::network) {
    at = row->place;
    if (row->against == Against::capacity || row->against == Against::schedule)
      held = held_by_others(at.index);
    else if (row->against == Against::medium_time)
      held = held_on_way(held_by_others(at.index), v, at.index, world_.meshes[at.index].get());
  }
  const std::string words = holders_words(system_, at.index, held);
  return words.empty() ? words : "; reserved there by " + words;
}

bool State::is_permitted(const Verdict& v) const {
  const Situation now = situation();
  return !unpermitted(now, ledger_, v) && !disagreement(now, v);
}

std::vector<std::size_t> State::wishes() const {
  if (permits_ == nullptr) return {};
  const Place self{Place::Kind::gateway, permits_->self()};
  const auto is_ours = [&](const Verdict& v) {
    const auto& routes = topology_.routes(members_.publisher(v.publisher).place, v.to);
    return std::ranges::any_of(
        routes, [&](const Route& route) { return std::ranges::find(route, self) != route.end(); });
  };
  std::erase_if(wished_, [this](std::size_t c) { return is_best(c); });
  std::vector<std::size_t> all;
  std::ranges::copy_if(wished_, std::back_inserter(all), [&](std::size_t c) {
    return std::ranges::any_of(decisions_[c].verdicts, is_ours);
  });
  return all;
}

}  // namespace mlcca::core
