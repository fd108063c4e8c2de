// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/state.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/admission/allocation.hpp"
#include "core/admission/permit_check.hpp"
#include "core/admission/route_check.hpp"
#include "core/model/progress.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

System sorted(System system) {
  system.sort_bindings();
  return system;
}

/// What gateways count together cannot be counted there.
bool is_uncountable(const Network& network, bool analysed, bool evaluated) {
  if (network.kind == NetworkKind::can && names_channels(network.profile))
    return !analysed || network.bus.bitrate == 0;
  return network.mesh.has_value() && (network.mesh->nodes.empty() || !evaluated);
}

void note_shared(const World& world, const Route& route, std::set<std::size_t>& networks) {
  for (const Place hop : hops_of(route))
    if (hop.kind == Place::Kind::network && world.shared[hop.index]) networks.insert(hop.index);
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

/// What is sized by the channels holds for those that come at run time too.
System with_room_for_unlisted(System system) {
  EventChannel blank;
  blank.unlisted = true;
  system.channels.resize(system.channels.size() + unlisted_room(system), blank);
  return system;
}

}  // namespace

// --- the state ----------------------------------------------------------------------------------

State::State(System system)
    : system_(with_room_for_unlisted(sorted(std::move(system)))),
      topology_(system_),
      members_(system_),
      world_(system_),
      withdrawn_(system_.channels.size(), false),
      ledger_(empty_ledger(system_, world_)),
      decisions_(system_.channels.size()),
      ages_(system_.channels.size(), 0),
      usage_(system_),
      own_there_(system_.networks.size(), false) {
  decide();
}

std::optional<std::string> State::exceeds_capacity(std::size_t gateway) const {
  for (std::size_t c = 0; c < decisions_.size(); ++c) {
    if (const auto lack =
            core::exceeds_capacity(system_, members_, c, decisions_[c].verdicts, gateway))
      return "channel " + system_.channels[c].name + ": " + *lack;
  }
  return std::nullopt;
}

void State::set_condition(std::size_t network, Condition condition) {
  if (condition == world_.conditions[network])
    new_.conditions.erase(network);
  else
    new_.conditions.insert_or_assign(network, std::move(condition));
}

void State::set_graph(std::size_t network, std::optional<mesh::Graph> graph,
                      std::vector<std::string> addresses) {
  new_.graphs.insert_or_assign(network, NewGraph{std::move(graph), std::move(addresses)});
}

void State::set_withdrawn(std::size_t channel, bool withdrawn) {
  if (withdrawn_[channel] == withdrawn) return;
  withdrawn_[channel] = withdrawn;
  touched_.insert(channel);
}

void State::set_tag(std::size_t network, std::size_t channel, std::uint32_t tag) {
  auto& bindings = system_.networks[network].bindings;
  const auto it = std::ranges::lower_bound(bindings, channel, {}, &Binding::channel);
  if (it == bindings.end() || it->channel != channel || it->id == tag) return;
  it->id = tag;
  touched_.insert(channel);
}

bool State::is_used(std::size_t channel) const {
  return !members_.publishers_of(channel).empty() || !members_.subscribers_of(channel).empty() ||
         touched_.contains(channel);
}

bool State::unlist_unused() {
  return unlisted_.remove_unused([this](std::size_t channel) { return is_used(channel); });
}

Result<std::size_t> State::list(const UnlistedChannel& wanted) {
  return unlisted_.list(wanted, world_.foreign,
                        [this](std::size_t channel) { return is_used(channel); });
}

void State::restore(Admission admission) {
  const std::size_t channel = admission.channel;
  admissions_.insert_or_assign(admission.id, channel);
  members_.add(admission.id, std::move(admission.publisher), std::move(admission.subscriber));
  note_age(channel);
  note_reservations(admission.id);
  touched_.insert(channel);
}

Admission State::admission(AdmissionId id) const {
  Admission out{id, admissions_.at(id), {}, {}};
  const Members::Admitted ends = members_.admitted(id);
  if (ends.publisher) out.publisher = members_.publisher(*ends.publisher);
  if (ends.subscriber) out.subscriber = members_.subscriber(*ends.subscriber);
  return out;
}

bool State::remove(AdmissionId id) {
  const auto it = admissions_.find(id);
  if (it == admissions_.end()) return false;
  const std::size_t channel = it->second;
  // What the others of the channel hold may depend on who left, so all of it is decided again.
  for (const std::size_t p : members_.publishers_of(channel)) ledger_.remove(p);
  forget_deliveries(channel, id);
  for (const std::size_t r : usage_.resources_of(channel)) relieved_.insert(r);
  note_reservations(id);
  if (const auto left = members_.admitted(id).publisher) ledger_.forget_placeholders(*left);
  members_.remove(id);
  admissions_.erase(it);
  note_age(channel);
  touched_.insert(channel);
  return true;
}

void State::invalidate_all() {
  for (std::size_t c = 0; c < system_.channels.size(); ++c) {
    touched_.insert(touched_.end(), c);
    Progress::step();
  }
  for (std::size_t r = 0; r < system_.resources(); ++r) relieved_.insert(r);
}

/// Those who stay are decided as if the one who leaves had never been granted anything.
void State::forget_deliveries(std::size_t channel, AdmissionId leaving) {
  Decision& decision = decisions_[channel];
  std::erase_if(decision.verdicts, [&](Verdict& v) {
    std::erase_if(v.subscribers,
                  [&](std::size_t s) { return members_.admission_of_subscriber(s) == leaving; });
    return v.subscribers.empty() || members_.admission_of_publisher(v.publisher) == leaving;
  });
  decision.granted = static_cast<std::size_t>(
      std::ranges::count_if(decision.verdicts, [](const Verdict& v) { return v.granted; }));
}

/// A channel that is complete without anyone from the run time is as old as the description.
void State::note_age(std::size_t channel) {
  ages_[channel] = 0;
  std::uint64_t oldest = kUnbounded;
  bool published = false;
  bool subscribed = false;
  for (const std::size_t p : members_.publishers_of(channel)) {
    const AdmissionId id = members_.admission_of_publisher(p);
    published = published || id == 0;
    if (id != 0) oldest = std::min(oldest, id);
  }
  for (const std::size_t s : members_.subscribers_of(channel)) {
    const AdmissionId id = members_.admission_of_subscriber(s);
    subscribed = subscribed || id == 0;
    if (id != 0) oldest = std::min(oldest, id);
  }
  if (!(published && subscribed) && oldest != kUnbounded) ages_[channel] = oldest;
}

Delivery State::delivery_of(const Verdict& v) const {
  return {members_.publisher(v.publisher).name, members_.admission_of_publisher(v.publisher),
          v.to.kind == Place::Kind::network ? system_.networks[v.to.index].name
                                            : system_.gateways[v.to.index].name};
}

Grants State::grants(std::size_t channel) const {
  Grants out;
  out.set = decisions_[channel].set;
  for (const Verdict& v : decisions_[channel].verdicts)
    if (v.granted) out.deliveries.push_back(delivery_of(v));
  return out;
}

/// What was granted, as far as those whom it concerns are there now.
Decision State::known(std::size_t channel, const Grants& grants) const {
  Decision out;
  out.set = grants.set;
  for (const Delivery& delivery : grants.deliveries) {
    const auto to = find_place(delivery.to);
    if (!to) continue;
    for (const std::size_t p : members_.publishers_of(channel)) {
      if (members_.publisher(p).name != delivery.publisher ||
          members_.admission_of_publisher(p) != delivery.admission)
        continue;
      Verdict& v = out.verdicts.emplace_back();
      v.channel = channel;
      v.publisher = p;
      v.to = *to;
      v.granted = true;
      v.sporadic = system_.channels[channel].arrival == Arrival::sporadic;
    }
  }
  out.granted = out.verdicts.size();
  return out;
}

void State::decide(const std::map<std::size_t, Grants>& before) {
  static_cast<void>(settle());
  Allocation allocation(situation(), ages_, decisions_, ledger_);
  std::vector<std::size_t> all(system_.channels.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  allocation.sort(all);
  for (const std::size_t c : all) {
    allocation.take_out(c);
    decisions_[c] = {};
  }
  ledger_.commit();
  bool all_kept = true;
  for (const std::size_t c : all) {
    const auto it = before.find(c);
    if (it == before.end() || it->second.set >= sets_of(system_, c)) continue;
    const Decision old = known(c, it->second);
    if (old.granted != 0 && !keep_after_restart(c, old)) all_kept = false;
  }
  if (all_kept)
    while (allocation.admit_waiting(all) || allocation.upgrade(all)) {
    }
  for (const std::size_t c : all) {
    usage_.set(situation(), c, decisions_[c]);
    Progress::step();
  }
  if (all_kept) return;
  // Others go down before one is withdrawn, as when a network gets worse at run time.
  for (std::size_t r = 0; r < system_.resources(); ++r) relieved_.insert(r);
  for (const std::size_t c : all)
    if (decisions_[c].granted == 0) touched_.insert(c);
  static_cast<void>(settle());
}

/// What a channel was granted, if it can be kept as it was. Else it is taken for granted and
/// touched, without anything in the ledger.
bool State::keep_after_restart(std::size_t channel, const Decision& old) {
  const Ledger::Mark mark = ledger_.mark();
  Decision now = decide_in(situation(), channel, old.set, ledger_, &old);
  const auto was_granted = [&](const Verdict& v) { return same_delivery(old, v) != nullptr; };
  const bool kept = std::ranges::none_of(
      now.verdicts, [&](const Verdict& v) { return !v.granted && was_granted(v); });
  if (!kept) {
    ledger_.roll_back(mark);
    // The ways are those that it would have.
    for (Verdict& v : now.verdicts) v.granted = was_granted(v);
    now.granted = static_cast<std::size_t>(std::ranges::count_if(now.verdicts, &Verdict::granted));
    touched_.insert(channel);
  }
  ledger_.commit();
  decisions_[channel] = std::move(now);
  return kept;
}

// --- gates --------------------------------------------------------------------------------------

GateChanges State::gate_changes(const std::vector<DecisionChange>& changes, std::size_t gateway,
                                const FormerRules& left) const {
  GateState before;
  GateState after;
  const auto append = [](GateState& to, const GateState& rules) {
    to.insert(to.end(), rules.begin(), rules.end());
  };
  for (const DecisionChange& change : changes) {
    const std::size_t c = change.channel;
    const auto known = left.find(c);
    append(before, known != left.end()
                       ? known->second
                       : core::gate_state(system_, members_, c, change.before.verdicts, gateway));
    append(after, gate_state(gateway, c));
    Progress::step();
  }
  std::ranges::sort(before, {}, Progress::At<&GateRule::entry>{});
  std::ranges::sort(after, {}, Progress::At<&GateRule::entry>{});
  return gate_changes_between(before, after);
}

std::vector<Hop> State::hops_of_granted(const Verdict& v) {
  Situation measuring = situation();
  measuring.keeps_hops = true;
  Verdict again = undecided(measuring, v.channel, v.publisher, {v.to, v.subscribers}, v.set);
  again.route = v.route;
  const Ledger::Mark before = ledger_.mark();
  check_route(measuring, ledger_, targets_of(members_, v.channel), again);
  ledger_.roll_back(before);
  ledger_.commit();
  return std::move(again.hops);
}

std::vector<DecisionChange> State::settle() {
  const bool permits_are_seen = permits_ == nullptr || seen_permits_.has_seen(*permits_);
  if (new_.empty() && touched_.empty() && relieved_.empty() && others_stale_.empty() &&
      permits_are_seen)
    return {};
  for (const auto& [network, condition] : new_.conditions) held_.forget(network);
  return settle_news(*this);
}

// --- where many gateways share networks
// ------------------------------------------------------------

void State::set_foreign(std::size_t network, cluster::Foreign foreign) {
  held_.forget(network);
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
  seen_permits_.reset(system_.networks.size());
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

/// What may not be held any more is decided again, and so is what could be given more.
void State::note_permits() {
  if (permits_ == nullptr) return;
  const PermitWatch::Changes now = seen_permits_.poll(*permits_);
  others_stale_.insert(now.networks.begin(), now.networks.end());
  for (const PermitWatch::Ended& ended : now.ended) touch_ended(ended.network, ended.since);
  if (now.disagreed_since) touch_disagreed(*now.disagreed_since);
  if (!now.more) return;
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

bool State::permitted(const Verdict& v, std::optional<std::uint64_t> without) const {
  const Situation now = situation();
  return !unpermitted(now, ledger_, v, without) && !disagreement(now, v, without);
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
