// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/state.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/many.hpp"
#include "base/number.hpp"
#include "core/admission/allocation.hpp"
#include "core/model/progress.hpp"
#include "core/model/text.hpp"

namespace mlcca::core {
namespace {

System sorted(System system) {
  system.sort_bindings();
  return system;
}

}  // namespace

// --- the state ----------------------------------------------------------------------------------

std::optional<std::string> State::exceeds_capacity(std::size_t gateway) const {
  for (std::size_t c = 0; c < decisions_.size(); ++c) {
    if (const auto lack =
            core::exceeds_capacity(system_, members_, c, decisions_[c].verdicts, gateway))
      return "channel " + system_.channels[c].name + ": " + *lack;
  }
  return std::nullopt;
}

namespace {

/// What is sized by the channels holds for those that come at run time too.
System with_room_for_unlisted(System system) {
  EventChannel blank;
  blank.unlisted = true;
  system.channels.resize(system.channels.size() + unlisted_room(system), blank);
  return system;
}

}  // namespace

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
  for (std::size_t c = 0; c < system_.channels.size(); ++c) {
    if (system_.channels[c].name.empty()) continue;
    channel_of_name_.emplace(system_.channels[c].name, c);
    channel_of_subject_.emplace(system_.channels[c].subject, c);
  }
  for (std::size_t n = 0; n < system_.networks.size(); ++n)
    place_of_name_.emplace(system_.networks[n].name, Place{Place::Kind::network, n});
  for (std::size_t g = 0; g < system_.gateways.size(); ++g)
    place_of_name_.emplace(system_.gateways[g].name, Place{Place::Kind::gateway, g});
  decide();
}

void State::set_condition(std::size_t network, Condition condition) {
  if (condition == world_.conditions[network])
    new_conditions_.erase(network);
  else
    new_conditions_.insert_or_assign(network, std::move(condition));
}

void State::set_graph(std::size_t network, std::optional<mesh::Graph> graph,
                      std::vector<std::string> addresses) {
  new_graphs_.insert_or_assign(network, NewGraph{std::move(graph), std::move(addresses)});
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

/// One that has no name was decided since it had one: nothing of it is granted, even if all
/// channels are about to be decided again.
std::optional<std::size_t> State::free_unlisted() const {
  for (std::size_t end = system_.channels.size(); end > 0; --end) {
    const std::size_t c = end - 1;
    if (!system_.channels[c].unlisted) break;
    if (system_.channels[c].name.empty() || !is_used(c)) return c;
  }
  return std::nullopt;
}

Result<void> State::check_room_for_unlisted(std::size_t channel,
                                            const UnlistedChannel& wanted) const {
  std::set<std::size_t> networks(wanted.networks.begin(), wanted.networks.end());
  for (const UnlistedBinding& b : wanted.bindings) networks.insert(b.network);
  for (const std::size_t n : networks) {
    const auto there = std::ranges::count_if(unlisted_, [&](const auto& other) {
      return other.first != channel && is_used(other.first) && other.second.contains(n);
    });
    if (static_cast<std::size_t>(there) >= system_.networks[n].unlisted.most)
      return fail(system_.networks[n].name + " has " +
                  many(there, "channel that is", "channels that are") +
                  " not described, and its Unlisted allows no more");
  }
  return {};
}

Result<void> State::check_same_identifiers(std::size_t channel,
                                           const UnlistedChannel& wanted) const {
  for (const UnlistedBinding& b : wanted.bindings) {
    const Binding* const there = system_.networks[b.network].binding_of(channel);
    if (there != nullptr && there->id != b.id)
      return fail("channel " + system_.channels[channel].name + " is admitted on " +
                  system_.networks[b.network].name + " with another identifier");
  }
  return {};
}

void State::empty_unlisted(std::size_t channel) {
  channel_of_name_.erase(system_.channels[channel].name);
  channel_of_subject_.erase(system_.channels[channel].subject);
  for (const std::size_t n : unlisted_[channel])
    std::erase_if(system_.networks[n].bindings,
                  [channel](const Binding& b) { return b.channel == channel; });
  unlisted_.erase(channel);
  system_.channels[channel] = {};
  system_.channels[channel].unlisted = true;
}

bool State::unlist_unused() {
  std::vector<std::size_t> unused;
  for (const auto& [channel, networks] : unlisted_)
    if (!is_used(channel)) unused.push_back(channel);
  for (const std::size_t channel : unused) empty_unlisted(channel);
  return !unused.empty();
}

Result<std::size_t> State::list(const UnlistedChannel& wanted) {
  const std::string name = format_subject(wanted.subject);
  if (wanted.subject == 0) return fail("subject 0 is not valid: a channel has another one");
  unlist_unused();
  const auto known = channel_of(wanted.subject);
  if (known && !system_.channels[*known].unlisted)
    return fail(name + " is described as channel " + system_.channels[*known].name + ": name that");
  if (!known && channel_of_name_.contains(name))
    return fail("a channel of another subject is called " + name);
  const auto at = known ? known : free_unlisted();
  if (!at) {
    // A client that is refused for lack of room asks again. So a refusal that lasts comes first: a
    // subject that a network does not allow never has room.
    if (auto allowed = check_unlisted(system_, system_.channels.size(), wanted); !allowed)
      return std::unexpected(allowed.error());
    return fail("there is no room for another channel that is not described: " +
                std::to_string(unlisted_.size()) + " are admitted");
  }
  if (auto allowed = check_unlisted(system_, *at, wanted); !allowed)
    return std::unexpected(allowed.error());
  if (auto room = check_room_for_unlisted(*at, wanted); !room) return std::unexpected(room.error());
  if (auto same = check_same_identifiers(*at, wanted); !same) return std::unexpected(same.error());
  if (auto free = check_foreign(system_, world_.foreign, wanted); !free)
    return std::unexpected(free.error());
  EventChannel& channel = system_.channels[*at];
  channel.name = name;
  channel.subject = wanted.subject;
  channel_of_name_.insert_or_assign(name, *at);
  channel_of_subject_.insert_or_assign(wanted.subject, *at);
  auto& networks = unlisted_[*at];
  networks.insert(wanted.networks.begin(), wanted.networks.end());
  for (const UnlistedBinding& b : wanted.bindings) {
    networks.insert(b.network);
    Network& network = system_.networks[b.network];
    if (network.binding_of(*at) == nullptr) bind(network, *at, b);
  }
  return *at;
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

GateChanges State::gate_changes(const std::vector<Change>& changes, std::size_t gateway,
                                const FormerRules& left) const {
  GateState before;
  GateState after;
  const auto append = [](GateState& to, const GateState& rules) {
    to.insert(to.end(), rules.begin(), rules.end());
  };
  for (const Change& change : changes) {
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
  return difference(before, after);
}

// --- names --------------------------------------------------------------------------------------

std::optional<std::size_t> State::find_channel(const std::string& name_or_subject) const {
  if (const auto subject = parse_subject(name_or_subject)) return channel_of(*subject);
  const auto it = channel_of_name_.find(name_or_subject);
  if (it == channel_of_name_.end()) return std::nullopt;
  return it->second;
}

std::optional<std::size_t> State::channel_of(Subject subject) const {
  const auto it = channel_of_subject_.find(subject);
  if (it == channel_of_subject_.end()) return std::nullopt;
  return it->second;
}

std::optional<Place> State::find_place(const std::string& name) const {
  const auto it = place_of_name_.find(name);
  if (it == place_of_name_.end()) return std::nullopt;
  return it->second;
}

std::optional<Subject> parse_subject(const std::string& text) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return std::nullopt;
  return number_in<Subject>(std::string_view(text).substr(2), kHexadecimalBase);
}

}  // namespace mlcca::core
