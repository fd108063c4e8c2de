// SPDX-License-Identifier: BSD-2-Clause
// Text about the ways of data and what they provide: routes, media, links of meshes, rules of
// can-gw.
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "tools/render.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

constexpr std::uint64_t kLossWhole = 1'000'000'000;
constexpr std::uint64_t kBusyWhole = 1'000'000;

Cell count_cell(std::uint32_t n, Style style) {
  return {fmt::format("{}", n), n == 0 ? Style::plain : style};
}

Cell places_of(const control::RouteReport& route) {
  if (!route.route.empty()) return {way(route.route)};
  return {route.problem.empty() ? "none" : "none: " + route.problem, Style::bad};
}

std::string ways(const std::vector<control::RouteReport>& all, Color color) {
  TextTable table(
      {{"FROM"}, {"TO"}, {"GRANTED", Align::right}, {"REFUSED", Align::right}, {"ROUTE"}});
  for (const auto& route : all)
    table.add({{route.from},
               {route.to},
               count_cell(route.granted, Style::good),
               count_cell(route.refused, Style::bad),
               places_of(route)});
  return table.empty() ? "no channel has a publisher and a subscriber\n" : table.text(color);
}

void add_medium(TextTable& table, const control::RouteReport& route,
                const control::MediumUse& use) {
  const bool mesh = use.path_rate != 0;
  table.add({{route.from},
             {route.to},
             {use.network},
             {use.response_ns == 0 ? "" : print_duration(use.response_ns)},
             {use.guaranteed_ns == 0 ? "" : print_duration(use.guaranteed_ns)},
             {way(use.path)},
             {mesh ? path_rate(use) : ""},
             {mesh ? bytes_per_second(use.available) : ""},
             {use.limited_by}});
}

std::string media(const std::vector<control::RouteReport>& all, Color color) {
  TextTable table({{"FROM"},
                   {"TO"},
                   {"NETWORK"},
                   {"RESPONSE", Align::right},
                   {"GUARANTEED", Align::right},
                   {"PATH"},
                   {"PATH RATE", Align::right},
                   {"AVAILABLE", Align::right},
                   {"LIMITED BY"}});
  for (const auto& route : all)
    for (const auto& use : route.media) add_medium(table, route, use);
  return table.empty() ? "" : "\nwhat their media give\n" + table.text(color, "  ");
}

Cell believed(const control::MeshLink& link) {
  return link.believed_rate == 0 ? Cell{"nothing", Style::bad}
                                 : Cell{bits_per_second(link.believed_rate)};
}

std::string links(const std::vector<control::MeshLink>& all, Color color) {
  TextTable table({{"NETWORK"},
                   {"FROM"},
                   {"TO"},
                   {"RATE", Align::right},
                   {"BELIEVED RATE", Align::right},
                   {"KIND"},
                   {"LOSS", Align::right},
                   {"BUSY", Align::right},
                   {"AGE", Align::right},
                   {"STATE"},
                   {"SOURCE"}});
  for (const auto& link : all)
    table.add({{link.network},
               {link.from},
               {link.to},
               {link.rate == 0 ? "unknown" : bits_per_second(link.rate)},
               believed(link),
               {link.kind},
               {link.loss_known ? percent(link.loss, kLossWhole) : ""},
               {link.busy_known ? percent(link.busy, kBusyWhole) : ""},
               {print_duration(link.age_ns)},
               {link.stale ? "stale" : link.state, Style::warning},
               {link.source}});
  return table.empty() ? "" : "\nlinks\n" + table.text(color, "  ");
}

/// The filter of a rule: an identifier "1f480064", several with the mask of the bits that count
/// "100/7ff", or "all"; inverted filters begin with "not".
std::string filter_of(const control::CanRule& rule) {
  constexpr std::uint32_t form = 0x80000000;
  constexpr std::uint32_t only_data = 0x40000000;
  constexpr std::uint32_t invert = 0x20000000;
  const std::uint32_t bits = (rule.id & form) != 0 ? 0x1fffffff : 0x7ff;
  const bool exact = (rule.mask & bits) == bits && (rule.mask & form) != 0 &&
                     (rule.mask & only_data) != 0 && (rule.id & only_data) == 0;
  const std::string inverted = (rule.id & invert) != 0 ? "not " : "";
  if (rule.mask == 0) return inverted + "all";
  if (exact) return inverted + print_can_id(rule.id & ~invert);
  return fmt::format("{}{:03x}/{:03x}", inverted, rule.id & ~invert, rule.mask);
}

Cell frames(std::uint64_t n, Style style = Style::plain) {
  return {fmt::format("{}", n), n == 0 ? Style::plain : style};
}

std::string can_rules(const std::vector<control::CanRule>& all, Color color) {
  TextTable table({{"FROM"},
                   {"TO"},
                   {"FILTER"},
                   {"FORMAT"},
                   {"OWNER"},
                   {"HANDLED", Align::right},
                   {"DROPPED", Align::right},
                   {"DELETED", Align::right},
                   {"HOPS", Align::right},
                   {"CHANGE"},
                   {"CHANNEL"}});
  for (const auto& rule : all)
    table.add({{rule.from},
               {rule.to},
               {filter_of(rule)},
               {rule.fd ? "FD" : "classic"},
               rule.ours ? Cell{"mlccad"} : Cell{"foreign", Style::warning},
               frames(rule.handled),
               frames(rule.dropped, Style::warning),
               rule.deleted == 0 ? Cell{} : frames(rule.deleted, Style::warning),
               {rule.hops == 0 ? "" : fmt::format("{}", rule.hops)},
               {rule.change},
               {rule.channel}});
  return table.empty() ? "" : "\ncan-gw rules\n" + table.text(color, "  ");
}

TextTable table_of(const std::vector<control::Transfer>& all) {
  TextTable table({{"CHANNEL"}, {"PUBLISHER"}, {"FROM"}, {"TO"}, {"USER", Align::right}});
  for (const auto& one : all)
    table.add({{one.channel},
               {one.publisher},
               {one.from.interface},
               {one.to.interface},
               {fmt::format("{}", one.user)}});
  return table;
}

std::string transfers(const control::Routes& routes, Color color) {
  const TextTable table = table_of(routes.transfers);
  if (table.empty()) return "";
  std::string text = "\ncarried by programs\n" + table.text(color, "  ");
  if (routes.transfers_left_out != 0)
    text += fmt::format("  and {} more\n", routes.transfers_left_out);
  return text;
}

/// Whose subscriptions count on a network.
std::string_view subscribers_of(const control::SubscriptionNetwork& network) {
  if (network.gateways_only) return "gateways";
  return network.accepts_all ? "all" : "who states attributes";
}

}  // namespace

std::string render(const control::Routes& routes, Color color) {
  auto text = ways(routes.routes, color) + media(routes.routes, color) +
              links(routes.links, color) + can_rules(routes.can_rules, color) +
              transfers(routes, color);
  if (!routes.problems.empty()) text += '\n';
  for (const auto& problem : routes.problems) text += styled(problem, Style::bad, color) + '\n';
  return text;
}

std::string render(const control::Transfers& transfers, Color color) {
  const TextTable table = table_of(transfers.transfers);
  return table.empty() ? "no program carries anything\n" : table.text(color);
}

std::string render(const control::Presence& presence, Color /*color*/) {
  if (presence.interval_ns == 0) return presence.gateway + " does not announce itself\n";
  std::string text = fmt::format("{} announces itself every {} on {}: it {}\n", presence.gateway,
                                 print_value("Period", presence.interval_ns, "ns"),
                                 fmt::join(presence.networks, ", "),
                                 presence.forwards ? "forwards" : "leaves its ways to others");
  for (const std::string& other : presence.not_received)
    text += fmt::format("nothing is received of {}\n", other);
  return text;
}

std::string render(const control::Subscriptions& subscriptions, Color color) {
  TextTable networks(
      {{"NETWORK"}, {"INTERFACE"}, {"ACCEPTS"}, {"MOST", Align::right}, {"PROBLEM"}});
  for (const auto& one : subscriptions.networks)
    networks.add({{one.network},
                  {one.endpoint.interface},
                  {std::string(subscribers_of(one))},
                  {fmt::format("{}", one.most)},
                  {one.problem, Style::bad}});
  TextTable onward({{"CHANNEL"}, {"NETWORK"}, {"REQUIRED"}, {"PROBLEM"}});
  for (const auto& one : subscriptions.onward) {
    std::string required;
    for (const auto& attribute : one.required)
      required += fmt::format("{}{} {}", required.empty() ? "" : ", ", attribute.name,
                              print_value(attribute.name, attribute.value, attribute.unit));
    onward.add({{one.channel}, {one.network}, {required}, {one.problem, Style::bad}});
  }
  std::string text = networks.empty() ? "no network accepts subscriptions\n" : networks.text(color);
  if (!onward.empty()) text += "\n" + onward.text(color);
  return text;
}

}  // namespace mlcca::tools
