// SPDX-License-Identifier: BSD-2-Clause
// Text about the cluster: the gateways that share networks through a store, and their reservations.
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/many.hpp"
#include "tools/render.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

constexpr std::size_t kShownDigits = 12;  // shown of a digest
constexpr std::uint64_t kMsOfTime = 1'000'000;
constexpr std::uint64_t kKilobyte = 1000;

std::string in_no_cluster(const std::string& gateway) {
  return fmt::format(
      "{} takes part in no cluster: it decides alone about networks that it shares. With "
      "/etc/mlcca/cluster.conf it takes part (mlcca-cluster(8)).\n",
      printable(gateway));
}

/// A time with less precision the longer it is: microseconds below 1 ms, then milliseconds, from 1
/// s tenths of a second, and from 60 s seconds.
std::string about_time(std::uint64_t ns) {
  constexpr std::uint64_t second = 1000 * kMsOfTime;
  if (ns >= 60 * second) return print_duration(ns - ns % second);
  if (ns >= second) return print_duration(ns - ns % (100 * kMsOfTime));
  if (ns >= kMsOfTime) return print_duration(ns - ns % kMsOfTime);
  constexpr std::uint64_t microsecond = 1000;
  return print_duration(ns - ns % microsecond);
}

std::string short_digest(const std::string& digest) { return digest.substr(0, kShownDigits); }

Style style_of_phase(std::string_view phase) {
  if (phase == "in") return Style::good;
  return phase == "joining" || phase == "draining" || phase == "drained" || phase == "waiting" ||
                 phase == "description-pending"
             ? Style::warning
             : Style::bad;
}

Cell shared_cell(const control::Cluster& cluster) {
  std::string networks = fmt::format("{}", fmt::join(cluster.networks, ", "));
  if (networks.empty()) networks = "no network";
  if (cluster.shared == "open") return {"open: " + networks, Style::good};
  if (cluster.shared == "described")
    return {"what is reserved is CLOSED, what is described is open: " + networks, Style::bad};
  return {"CLOSED: " + networks, Style::bad};
}

std::string description_of(const control::Cluster& cluster) {
  const std::string own = short_digest(cluster.own_digest);
  if (cluster.digest.empty())
    return fmt::format("none is in force; that of this gateway is {}", own);
  const std::string force =
      fmt::format("{} of generation {}, {}", short_digest(cluster.digest), cluster.generation,
                  cluster.in_force ? "in force" : "comes into force");
  return force + (cluster.digest == cluster.own_digest
                      ? ": the one of this gateway"
                      : fmt::format(": this gateway has another one, {}", own));
}

std::string lease_of(const control::Cluster& cluster) {
  const std::string lease = print_duration(cluster.lease_ns);
  return cluster.lasts_ns == 0
             ? lease + ", ended: what is reserved is closed"
             : fmt::format("{}, lasts for {} surely", lease, about_time(cluster.lasts_ns));
}

std::string store_of(const control::Cluster& cluster) {
  const std::string since = about_time(cluster.store_for_ns);
  if (!cluster.store_up)
    return fmt::format("does not answer, for {}{}{}", since,
                       cluster.store_problem.empty() ? "" : ": ", cluster.store_problem);
  std::string out = fmt::format("answers, for {}", since);
  if (!cluster.store_endpoint.empty()) out += ", " + cluster.store_endpoint;
  if (cluster.store_latency_ns != 0) out += ", in " + about_time(cluster.store_latency_ns);
  if (cluster.store_bytes != 0) out += fmt::format(", {} kB", cluster.store_bytes / kKilobyte);
  return out + (cluster.store_full ? ", FULL" : "");
}

Cell state_cell(const std::string& state) {
  if (state == "active") return {state, Style::good};
  const bool gone = state == "silent" || state == "fenced" || state == "absent";
  return {state, gone ? Style::bad : Style::warning};
}

Cell description_cell(const control::ClusterMember& member) {
  if (member.digest.empty()) return {};
  const std::string digest = short_digest(member.digest);
  if (member.other) return {digest + " another one", Style::bad};
  return {member.generation == 0 ? digest : fmt::format("{} ({})", digest, member.generation)};
}

std::string carries_of(const control::ClusterMember& member) {
  std::string out = fmt::format("{}", fmt::join(member.carries, ", "));
  if (member.carries_left_out != 0) out += fmt::format(" and {} more", member.carries_left_out);
  return out;
}

/// Members that the description no longer has but whose entries are still in the store.
std::string left_by_removed(const control::ClusterMembers& members) {
  std::string out;
  for (const auto& one : members.members) {
    if (one.state != "removed") continue;
    out += fmt::format("{} is not described, and the store has {} of it: {}\n", printable(one.name),
                       many(one.entries, "entry", "entries"),
                       one.removal.empty() ? "it may still send"
                                           : "nobody can use that any more. Delete it as root of "
                                             "etcd:\n  " +
                                                 printable(one.removal));
  }
  return out;
}

Cell number_cell(std::uint64_t n) { return {n == 0 ? std::string() : fmt::format("{}", n)}; }

Cell reservation_cell(const std::string& state) {
  if (state == "granted") return {state, Style::good};
  return {state, state == "unreadable" ? Style::bad : Style::warning};
}

}  // namespace

std::string render(const control::Cluster& cluster, Color color) {
  if (cluster.system.empty()) return in_no_cluster(cluster.gateway);
  std::string text;
  const auto line = [&](std::string_view name, const std::string& value,
                        Style style = Style::plain) {
    text += fmt::format("{:<12}  {}\n", name, styled(value, style, color));
  };
  line("gateway", fmt::format("{} of {}", cluster.gateway, cluster.system), Style::bold);
  line("phase", cluster.phase, style_of_phase(cluster.phase));
  const auto [words, style] = shared_cell(cluster);
  line("shared", words, style);
  for (const auto& reason : cluster.health.reasons) line("problem", reason, Style::bad);
  line("description", description_of(cluster),
       cluster.digest == cluster.own_digest ? Style::plain : Style::bad);
  line("lease", lease_of(cluster));
  line("incarnation", fmt::format("{}, epoch {}", cluster.incarnation,
                                  cluster.epoch.empty() ? "none" : cluster.epoch));
  line("store", store_of(cluster), cluster.store_up ? Style::plain : Style::bad);
  line("gateways", fmt::format("{} of {} are there", cluster.present, cluster.gateways));
  line("reservations", fmt::format("{} in the store", cluster.reservations));
  if (cluster.unreadable != 0)
    line("unreadable", many(cluster.unreadable, "entry", "entries") + " of the store", Style::bad);
  return text;
}

std::string render(const control::ClusterMembers& members, Color color) {
  if (members.system.empty()) return in_no_cluster(members.gateway);
  TextTable table({{"GATEWAY"},
                   {"STATE"},
                   {"BEAT AGE", Align::right},
                   {"LEASE", Align::right},
                   {"LASTS", Align::right},
                   {"DESCRIPTION"},
                   {"RESERVED", Align::right},
                   {"BESIDE"},
                   {"CARRIES"}});
  for (const auto& one : members.members) {
    std::uint64_t reserved = 0;
    for (const auto& share : one.shares) reserved += share.reservations;
    table.add({{one.own ? one.name + " *" : one.name, Style::bold},
               state_cell(one.state),
               {one.beats ? about_time(one.beat_age_ns) : ""},
               {one.lease_ns == 0 ? "" : print_duration(one.lease_ns)},
               {one.lasts_ns == 0 ? "" : about_time(one.lasts_ns)},
               description_cell(one),
               {one.state == "removed" ? "" : fmt::format("{}", reserved)},
               {fmt::format("{}", fmt::join(one.beside, ", "))},
               {carries_of(one)}});
  }
  return table.text(color) + "* this gateway\n" + left_by_removed(members);
}

std::string render(const control::ClusterReservations& reservations, Color color) {
  if (reservations.system.empty()) return in_no_cluster(reservations.gateway);
  TextTable table({{"NETWORK"},
                   {"GATEWAY"},
                   {"CHANNEL"},
                   {"PUBLISHER"},
                   {"AMOUNT", Align::right},
                   {"MESSAGES", Align::right},
                   {"PATHS", Align::right},
                   {"STATE"},
                   {"THROUGH"}});
  for (const auto& one : reservations.reservations)
    table.add({{one.network, Style::bold},
               {one.gateway == reservations.gateway ? one.gateway + " *" : one.gateway},
               {one.channel},
               {one.publisher},
               {one.bytes_per_second == 0 ? "" : bytes_per_second(one.bytes_per_second)},
               number_cell(one.messages),
               number_cell(one.paths),
               reservation_cell(one.state),
               {fmt::format("{}", fmt::join(one.through, ", "))}});
  return table.empty() ? "nothing is reserved\n" : table.text(color);
}

std::string what_closes(const control::Cluster& cluster, bool until_restart, Color color) {
  return fmt::format("{}: {}; what it has reserved is given back, until {}\n",
                     printable(cluster.gateway),
                     styled(fmt::format("{} {}", fmt::join(cluster.networks, ", "),
                                        cluster.networks.size() == 1 ? "closes" : "close"),
                            Style::bad, color),
                     until_restart ? "mlccad is started again" : "'mlccactl cluster join'");
}

}  // namespace mlcca::tools
