// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/cluster_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <ranges>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/cluster/keys.hpp"
#include "daemon/gateway/health.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

/// The phase of this gateway, as the store has it where that is more specific.
std::string phase_of(const Membership& membership) {
  const cc::Member& member = membership.member();
  if (membership.is_drained()) return membership.has_left() ? "drained" : "draining";
  const bool fenced = member.view().complete() && member.view().is_fenced(member.self());
  switch (member.standing(membership.now())) {
    case cc::Member::Standing::off:
    case cc::Member::Standing::joining:
      return fenced ? "fenced" : "joining";
    case cc::Member::Standing::joined:
      return "in";
    case cc::Member::Standing::silent:
      return "silent";
    case cc::Member::Standing::gone_back:
      return "gone-back";
    case cc::Member::Standing::waiting:
      return "waiting";
    case cc::Member::Standing::other_digest: {
      const auto& current = member.view().records().current.value;
      const bool other = current && current->digest != membership.digest();
      return other ? "other-description" : "description-pending";
    }
    case cc::Member::Standing::draining:
      break;
  }
  return "draining";
}

std::string shared_words(const core::Permits& permits) {
  if (permits.is_open()) return "open";
  return permits.standing_is_open() ? "described" : "closed";
}

std::string state_of(const cc::View& view, std::size_t gateway, Value now) {
  const auto& record = view.records().members[gateway];
  const auto alive = view.alive(gateway, now);
  if (view.is_fenced(gateway)) return "fenced";
  if (record.mod == 0) return alive == cc::Alive::absent ? "absent" : "silent";
  if (!record.beat || now >= view.counts_until(gateway) || alive == cc::Alive::silent)
    return "silent";
  if (record.beat->draining) return "draining";
  if (record.beat->role == cc::Role::standby) return "standby";
  return record.beat->role == cc::Role::taking ? "taking" : "active";
}

bool is_present(std::string_view state) {
  return state == "active" || state == "taking" || state == "standby";
}

/// What a reservation takes of its network.
struct Amount {
  Value bytes_per_second = 0;
  std::size_t messages = 0;
  std::size_t paths = 0;
};
Amount amount_of(const cc::Part& part) {
  Amount out{.messages = part.bus.size(), .paths = part.paths.size()};
  for (const cc::RatePart& rate : part.rates)
    out.bytes_per_second = add_saturating(out.bytes_per_second, rate.bytes_per_second);
  if (!part.rates.empty()) return out;
  for (const cc::PathPart& path : part.paths)
    out.bytes_per_second = add_saturating(out.bytes_per_second, path.bytes_per_second);
  return out;
}

/// For each gateway, the channels that it carries from one network to another.
std::vector<std::set<std::size_t>> carried(const core::State& state) {
  std::vector<std::set<std::size_t>> out(state.system().gateways.size());
  for (const core::Decision& decision : state.decisions())
    for (const core::Verdict& verdict : decision.verdicts) {
      if (!verdict.granted) continue;
      // A route that ends at a gateway does not cross it.
      for (std::size_t i = 1; i + 1 < verdict.route.size(); ++i)
        if (verdict.route[i].kind == core::Place::Kind::gateway)
          out[verdict.route[i].index].insert(verdict.channel);
    }
  return out;
}

using Shares = std::map<std::pair<std::size_t, std::size_t>, control::ClusterShare>;

/// Adds up reservations. Traffic that several reservations contain is counted once.
class Sum {
 public:
  void take(const cc::Part& part) {
    for (const cc::RatePart& rate : part.rates) most(rates_[rate.source], rate.bytes_per_second);
    for (const cc::BusPart& bus : part.bus) messages_.insert(bus.source);
    if (!part.rates.empty()) return;
    for (const cc::PathPart& path : part.paths)
      most(paths_[{path.source, path.from, path.to}], path.bytes_per_second);
  }
  [[nodiscard]] std::size_t messages() const { return messages_.size(); }
  [[nodiscard]] Value bytes_per_second() const {
    Value sum = 0;
    for (const Value bytes : std::views::values(rates_)) sum = add_saturating(sum, bytes);
    for (const Value bytes : std::views::values(paths_)) sum = add_saturating(sum, bytes);
    return sum;
  }

 private:
  static void most(Value& of, Value bytes) { of = std::max(of, bytes); }

  std::map<cc::Source, Value> rates_;
  std::map<std::tuple<cc::Source, std::uint32_t, std::uint32_t>, Value> paths_;
  std::set<cc::Source> messages_;
};

/// The shares of all reservations, by gateway and network.
Shares shares_of(const cc::View& view, const core::System& system) {
  Shares out;
  std::map<Shares::key_type, Sum> sums;
  for (const auto& [key, record] : view.records().reservations) {
    control::ClusterShare& share = out[{key.gateway, key.network}];
    share.network = system.networks[key.network].name;
    ++share.reservations;
    if (record.taken) sums[{key.gateway, key.network}].take(record.taken->part);
  }
  for (const auto& [key, sum] : sums) {
    out[key].bytes_per_second = sum.bytes_per_second();
    out[key].messages = sum.messages();
  }
  return out;
}

/// Keeps the first `most` names. Returns how many were removed.
std::uint32_t cut(std::vector<std::string>& names, std::size_t most) {
  if (names.size() <= most) return 0;
  const auto more = static_cast<std::uint32_t>(names.size() - most);
  names.resize(most);
  return more;
}

void add_beat(const Membership& membership, std::size_t gateway, control::ClusterMember& to) {
  const cc::View& view = membership.member().view();
  const Value now = membership.now();
  const auto& record = view.records().members[gateway];
  to.beats = record.beat.has_value();
  if (const auto seen = view.seen_at(gateway)) to.beat_age_ns = sub_floor(now, *seen);
  const auto alive = view.alive(gateway, now);
  if (to.own)
    to.lasts_ns = sub_floor(membership.member().valid_until(), now);
  else if (alive != cc::Alive::absent && alive != cc::Alive::fenced)
    to.lasts_ns = sub_floor(view.counts_until(gateway), now);
  if (!record.beat) return;
  const cc::Beat& beat = *record.beat;
  const auto& current = view.records().current.value;
  to.incarnation =
      static_cast<std::uint64_t>(beat.incarnation != 0 ? beat.incarnation : record.mod);
  to.lease_ns = beat.lease;
  to.digest = cc::hex_of(beat.digest);
  to.generation = beat.generation;
  to.other = current && current->digest != beat.digest;
}

std::string state_of(const cc::Records& records, const cc::Records::ReservationKey& key,
                     const cc::ReservationRecord& record) {
  if (!record.taken) return "unreadable";
  if (record.mod < records.members[key.gateway].fence) return "ending";
  const auto asked = records.asked.find({key.gateway, key.id});
  if (asked == records.asked.end()) return "ending";
  switch (asked->second.asked.stage) {
    case cc::Stage::prepared:
      return "pending";
    case cc::Stage::granted:
      return "granted";
    case cc::Stage::ending:
      break;
  }
  return "ending";
}

void add_store(const Membership& membership, control::Cluster& to) {
  const cc::StoreState& store = membership.store();
  to.store_up = store.reachable;
  to.store_for_ns = sub_floor(membership.now(), membership.store_since());
  to.store_endpoint = store.endpoint;
  to.store_problem = store.problem;
  to.store_latency_ns = store.latency_ns;
  to.store_bytes = store.db_bytes;
  to.store_full = store.no_space;
}

void add_description(const Membership& membership, control::Cluster& to) {
  to.own_digest = cc::hex_of(membership.digest());
  const auto& current = membership.member().view().records().current.value;
  if (!current) return;
  to.generation = current->generation;
  to.digest = cc::hex_of(current->digest);
  to.in_force = current->open;
}

}  // namespace

control::Cluster cluster_report(const Membership& membership, const core::State& state) {
  const core::System& system = state.system();
  const cc::Member& member = membership.member();
  const cc::Records& records = member.view().records();
  control::Cluster out;
  out.gateway = system.gateways[member.self()].name;
  out.system = system.name;
  out.phase = phase_of(membership);
  out.why = membership.standing();
  out.shared = shared_words(membership.permits());
  for (const core::Port& port : system.gateways[member.self()].ports)
    if (state.world().shared[port.network])
      out.networks.push_back(system.networks[port.network].name);
  out.health = health_of(out.shared != "closed", membership.problems());
  out.incarnation = static_cast<std::uint64_t>(member.journalled().incarnation);
  if (records.epoch.value) out.epoch = cc::hex_of(*records.epoch.value);
  out.lease_ns = membership.lease();
  out.lasts_ns = sub_floor(member.valid_until(), membership.now());
  add_description(membership, out);
  add_store(membership, out);
  out.gateways = static_cast<std::uint32_t>(system.gateways.size());
  for (std::size_t g = 0; g < system.gateways.size(); ++g)
    if (is_present(state_of(member.view(), g, membership.now()))) ++out.present;
  out.reservations = records.reservations.size();
  out.unreadable = records.strange.size();
  return out;
}

namespace {

/// The beginning of a key up to and including the gateway's name, which all keys of that gateway of
/// this kind have, and no others.
std::string folder_of(const std::string& key, cc::Key::Kind kind, std::size_t prefix) {
  std::size_t end = prefix;
  for (int words = kind == cc::Key::Kind::reservation ? 3 : 2; words > 0; --words)
    end = key.find('/', end) + 1;
  return key.substr(0, end);
}

/// The commands that delete everything that a removed gateway has left; its beat and its fence come
/// last, because they say that it is dead.
std::string removal_of(const cc::LeftRecord& left, std::size_t prefix) {
  constexpr std::size_t most = 64;
  std::vector<std::string> commands;
  const auto add = [&](const std::string& command) {
    if (commands.size() < most && std::ranges::find(commands, command) == commands.end())
      commands.push_back(command);
  };
  const auto add_last = [&](cc::Key::Kind kind) {
    for (const auto& [name, key] : left.keys)
      if (key.kind == kind) add("etcdctl del " + name);
  };
  for (const auto& [name, key] : left.keys) {
    if (key.voter) continue;
    if (key.kind == cc::Key::Kind::rollout_vote)
      add("etcdctl del " + name);
    else if (key.kind != cc::Key::Kind::member && key.kind != cc::Key::Kind::fence)
      add("etcdctl del --prefix " + folder_of(name, key.kind, prefix));
  }
  add_last(cc::Key::Kind::member);
  add_last(cc::Key::Kind::fence);
  return fmt::format("{}", fmt::join(commands, " && "));
}

/// Adds gateways that are not in the description, but of which the store has more entries than this
/// gateway deletes by itself.
void add_removed(const cc::View& view, Value now, control::ClusterMembers& to) {
  constexpr std::size_t most = 256;
  for (const auto& [name, left] : view.records().left) {
    if (left.keys.empty()) continue;
    if (to.members.size() >= view.keys().gateways() + most) return;
    control::ClusterMember& one = to.members.emplace_back();
    one.name = name;
    one.state = "removed";
    one.entries = left.keys.size();
    if (view.is_over(name, now)) one.removal = removal_of(left, view.keys().prefix().size());
  }
}

}  // namespace

control::ClusterMembers cluster_members(const Membership& membership, const core::State& state) {
  const core::System& system = state.system();
  const cc::Member& own = membership.member();
  const auto carries = carried(state);
  const Shares shares = shares_of(own.view(), system);
  control::ClusterMembers out{
      .gateway = system.gateways[own.self()].name, .system = system.name, .members = {}};
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    control::ClusterMember& to = out.members.emplace_back();
    to.name = system.gateways[g].name;
    to.own = g == own.self();
    to.state = state_of(own.view(), g, membership.now());
    add_beat(membership, g, to);
    for (std::size_t other = 0; other < system.gateways.size(); ++other)
      if (other != g && own.view().keys().side_by_side(g, other))
        to.beside.push_back(system.gateways[other].name);
    cut(to.beside, control::ClusterMember::kMostBeside);
    for (const std::size_t channel : carries[g])
      to.carries.push_back(system.channels[channel].name);
    to.carries_left_out = cut(to.carries, control::ClusterMember::kMostCarries);
    for (auto it = shares.lower_bound({g, 0}); it != shares.end() && it->first.first == g; ++it)
      if (to.shares.size() < control::ClusterMember::kMostShares) to.shares.push_back(it->second);
  }
  add_removed(own.view(), membership.now(), out);
  return out;
}

control::ClusterReservations cluster_reservations(const Membership& membership,
                                                  const core::State& state,
                                                  std::optional<std::size_t> network,
                                                  std::optional<std::size_t> gateway) {
  const core::System& system = state.system();
  const cc::Member& own = membership.member();
  const cc::Records& records = own.view().records();
  control::ClusterReservations out{
      .gateway = system.gateways[own.self()].name, .system = system.name, .reservations = {}};
  for (const auto& [key, record] : records.reservations) {
    if ((network && key.network != *network) || (gateway && key.gateway != *gateway)) continue;
    control::ClusterReservation& to = out.reservations.emplace_back();
    to.network = system.networks[key.network].name;
    to.gateway = system.gateways[key.gateway].name;
    to.number = key.id;
    to.state = state_of(records, key, record);
    if (!record.taken) continue;
    to.channel = record.taken->channel;
    to.publisher = record.taken->publisher;
    const Amount amount = amount_of(record.taken->part);
    to.bytes_per_second = amount.bytes_per_second;
    to.messages = amount.messages;
    to.paths = amount.paths;
    for (const std::size_t through : record.taken->through)
      to.through.push_back(system.gateways[through].name);
    cut(to.through, control::ClusterReservation::kMostThrough);
  }
  return out;
}

}  // namespace mlcca
