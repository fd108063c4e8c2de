// SPDX-License-Identifier: BSD-2-Clause
// Renders the status of the gateway, its interfaces and its networks.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "tools/render.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

Cell link(const control::Interface& interface) {
  if (interface.ifindex == 0) return {"absent", Style::warning};
  return interface.up ? Cell{"up", Style::good} : Cell{"down", Style::warning};
}

Cell gate(const control::Interface& interface) {
  if (interface.ifindex == 0) return {};
  if (interface.profile == "none")
    return interface.attached ? Cell{"closed: no profile", Style::bad} : Cell{"none: not enforced"};
  if (!interface.attached) return {"NOT ATTACHED", Style::bad};
  return {interface.drops_early ? "attached early" : "attached", Style::good};
}

Style style_of_can_state(std::string_view state) {
  if (state == "ERROR-ACTIVE") return Style::good;
  return state == "BUS-OFF" ? Style::bad : Style::warning;
}

Cell number(std::uint64_t n, Style style = Style::plain) {
  return {fmt::format("{}", n), n == 0 ? Style::plain : style};
}

/// A counter that only audit mode increases; an empty cell for 0.
Cell number_if_any(std::uint64_t n) {
  return n == 0 ? Cell{} : Cell{fmt::format("{}", n), Style::warning};
}

std::string interfaces(const std::vector<control::Interface>& all, Color color) {
  TextTable table({{"INTERFACE"},
                   {"NETWORK"},
                   {"PROFILE"},
                   {"LINK"},
                   {"CAN STATE"},
                   {"BITRATE", Align::right},
                   {"GATE"},
                   {"SLOTS", Align::right},
                   {"IN PASSED", Align::right},
                   {"IN DROPPED", Align::right},
                   {"IN WOULD DROP", Align::right},
                   {"OUT PASSED", Align::right},
                   {"OUT DROPPED", Align::right},
                   {"OUT WOULD DROP", Align::right},
                   {"MANAGED"},
                   {"IDENTITY"}});
  for (const auto& one : all)
    table.add({{one.name, Style::bold},
               {one.network},
               {one.profile},
               link(one),
               {one.can_state, style_of_can_state(one.can_state)},
               {one.bitrate == 0 ? "" : print_bitrate(one.bitrate)},
               gate(one),
               number(one.slots),
               number(one.ingress.passed),
               number(one.ingress.dropped, Style::warning),
               number_if_any(one.ingress.would_drop),
               number(one.egress.passed),
               number(one.egress.dropped, Style::warning),
               number_if_any(one.egress.would_drop),
               {one.managed ? "yes" : ""},
               {one.identity}});
  return table.text(color);
}

void add_reasons(TextTable& table, const std::string& interface, const char* direction,
                 const control::Traffic& traffic) {
  const auto frames_of = [](const auto& reasons, const std::string& reason) -> std::uint64_t {
    for (const auto& count : reasons)
      if (count.reason == reason) return count.frames;
    return 0;
  };
  const auto add = [&](const std::string& reason, std::uint64_t frames, std::uint64_t would_drop) {
    if (frames != 0 || would_drop != 0)
      table.add({{interface},
                 {direction},
                 {reason},
                 frames != 0 ? number(frames) : Cell{},
                 number_if_any(would_drop)});
  };
  for (const auto& count : traffic.reasons)
    add(count.reason, count.frames, frames_of(traffic.would_drop_reasons, count.reason));
  for (const auto& count : traffic.would_drop_reasons)
    if (std::ranges::find(traffic.reasons, count.reason, &control::ReasonCount::reason) ==
        traffic.reasons.end())
      add(count.reason, 0, count.frames);
}

std::string reasons(const std::vector<control::Interface>& all, Color color) {
  TextTable table({{"INTERFACE"},
                   {"DIRECTION"},
                   {"REASON"},
                   {"FRAMES", Align::right},
                   {"WOULD DROP", Align::right}});
  for (const auto& one : all) {
    add_reasons(table, one.name, "in", one.ingress);
    add_reasons(table, one.name, "out", one.egress);
  }
  return table.empty() ? "" : "\nframes by reason\n" + table.text(color, "  ");
}

/// A datagram may have the subject 0.
bool names_subject(const control::Unknown& frame) {
  return frame.subject != 0 || !frame.address.empty() || !frame.mac.empty();
}

std::string name_of_unknown(const control::Unknown& frame) {
  return names_subject(frame) ? core::format_subject(frame.subject) : print_can_id(frame.can_id);
}

std::string format_of_unknown(const control::Unknown& frame) {
  if (names_subject(frame)) return "datagram";
  if (frame.xl) return "XL";
  return frame.fd ? "FD" : "classic";
}

std::string unknown_frames(const std::vector<control::Interface>& all, Color color) {
  TextTable table({{"INTERFACE"},
                   {"DIRECTION"},
                   {"IDENTIFIER"},
                   {"FORMAT"},
                   {"LENGTH", Align::right},
                   {"FRAMES", Align::right},
                   {"SENDER"},
                   {"CHANNEL"}});
  for (const auto& one : all)
    for (const auto& frame : one.unknown)
      table.add({{one.name},
                 {frame.egress ? "out" : "in"},
                 {name_of_unknown(frame)},
                 {format_of_unknown(frame)},
                 number(frame.length),
                 number(frame.frames),
                 {print_sender(frame)},
                 {printable(frame.channel)}});
  return table.empty() ? "" : "\nunknown frames, last seen first\n" + table.text(color, "  ");
}

std::string problems(const std::vector<control::Interface>& all, Color color) {
  std::string text;
  for (const auto& one : all) {
    if (!one.problem.empty())
      text += styled(one.name + ": " + one.problem, Style::bad, color) + '\n';
    if (!one.drift.empty()) text += styled(one.drift, Style::bad, color) + '\n';
    if (one.bypassed != 0)
      text += styled(fmt::format("{}: {} sent past its gate", one.name,
                                 many(one.bypassed, "frame was", "frames were")),
                     Style::bad, color) +
              '\n';
  }
  return text;
}

Cell health_cell(const control::Health& health) {
  switch (health.state) {
    case control::HealthState::healthy:
      return {"healthy", Style::good};
    case control::HealthState::degraded:
      return {"DEGRADED", Style::bad};
    case control::HealthState::closed:
      return {"CLOSED", Style::bad};
    case control::HealthState::unknown:
      break;
  }
  return {"unknown: this mlccad does not say", Style::warning};
}

std::string left_out(const control::Health& health) {
  return health.left_out == 0 ? "" : fmt::format("and {} more", health.left_out);
}

std::string mode_of(const control::Status& status) {
  std::string mode =
      status.mode +
      (status.audit_until_enforced ? ", over restarts until 'mlccactl mode enforce'" : "");
  if (status.when_clean_ns == 0) return mode;
  return fmt::format("{}; enforces when nothing would have been dropped for {}: it has been {}",
                     mode, core::format_span(status.when_clean_ns),
                     core::format_span(status.clean_ns));
}

std::string provision(const control::Network& network) {
  std::vector<std::string> parts;
  parts.reserve(network.provision.size());
  for (const auto& attribute : network.provision)
    parts.push_back(fmt::format("{} {}{}", attribute.name, attribute.dynamic ? "at best " : "",
                                print_value(attribute.name, attribute.value, attribute.unit)));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string rate(std::uint64_t bytes_per_second) {
  return print_value("Bandwidth", bytes_per_second, "bytes/s");
}

}  // namespace

std::string health_lines(const control::Health& health, Color color) {
  const auto [text, style] = health_cell(health);
  std::string lines = fmt::format("{:<11}  {}\n", "health", styled(text, style, color));
  for (const auto& reason : health.reasons)
    lines += fmt::format("{:<11}  {}\n", "", styled(reason, Style::bad, color));
  if (const auto more = left_out(health); !more.empty())
    lines += fmt::format("{:<11}  {}\n", "", more);
  return lines;
}

std::string render(const control::Status& status, Color color) {
  std::string text;
  const auto line = [&](std::string_view name, std::string_view value, Style style = Style::plain) {
    text += fmt::format("{:<11}  {}\n", name, styled(value, style, color));
  };
  if (status.mode != "enforce")
    text += styled("AUDIT MODE: nothing is dropped, unfit data passes", Style::bad, color) + '\n';
  line("gateway", fmt::format("{} of {}", status.gateway, status.system), Style::bold);
  line("mlccad", fmt::format("{}, since {}", status.version, print_second(status.started_unix_s)));
  line("description",
       fmt::format("{}, read {}", status.description_file, print_second(status.loaded_unix_s)));
  if (status.open)
    line("gate", "open: verdicts are in force", Style::good);
  else
    line("gate", "CLOSED: everything is denied", Style::bad);
  text += health_lines(status.health, color);
  line("mode", mode_of(status), status.mode == "enforce" ? Style::good : Style::bad);
  line("channels",
       fmt::format("{} granted, {} refused", status.channels_granted, status.channels_refused));
  line("grace",
       fmt::format("{}, lapsed {}", print_duration(status.grace_ns),
                   status.lapses == 1 ? "once" : many(status.lapses, "time")),
       status.lapses == 0 ? Style::plain : Style::warning);
  // For a newer daemon the reasons of its health include these.
  const bool older = status.health.state == control::HealthState::unknown;
  if (older && !status.problem.empty()) line("problem", status.problem, Style::bad);
  if (older && !status.reload_error.empty()) line("last reload", status.reload_error, Style::bad);
  if (!status.interfaces.empty()) text += '\n' + interfaces(status.interfaces, color);
  return text + (older ? problems(status.interfaces, color) : "") +
         reasons(status.interfaces, color) + unknown_frames(status.interfaces, color);
}

std::string check_line(const control::Health& health) {
  auto reasons = health.reasons;
  if (const auto more = left_out(health); !more.empty()) reasons.push_back(more);
  const bool known = health.state != control::HealthState::unknown;
  if (!known && reasons.empty()) reasons.emplace_back("this mlccad does not say");
  std::string line = known ? health_cell(health).text : "UNKNOWN";
  if (!reasons.empty()) line += fmt::format(": {}", fmt::join(reasons, "; "));
  return printable(line) + '\n';
}

std::string render(const control::Networks& networks, Color color) {
  TextTable table({{"NETWORK"},
                   {"KIND"},
                   {"PROFILE"},
                   {"STATE"},
                   {"RESERVED", Align::right},
                   {"CAPACITY", Align::right},
                   {"GATEWAYS"},
                   {"PROVISION"}});
  for (const auto& network : networks.networks)
    table.add({{network.name, Style::bold},
               {network.kind},
               {network.profile},
               network.available ? Cell{"available", Style::good} : Cell{"unavailable", Style::bad},
               {rate(network.reserved)},
               {network.capacity_known ? rate(network.capacity) : "unknown"},
               {fmt::format("{}", fmt::join(network.gateways, ", "))},
               {provision(network)}});
  auto text = table.empty() ? "no networks are described\n" : table.text(color);
  for (const auto& network : networks.networks)
    if (!network.problem.empty())
      text += styled(network.name + ": " + network.problem, Style::bad, color) + '\n';
  return text;
}

std::string render(const control::Rollout& rollout, Color color) {
  constexpr std::size_t shown = 12;
  std::string text;
  const auto line = [&](const char* what, const std::string& value, Style shown_as = Style::plain) {
    if (!value.empty()) text += fmt::format("{:<13}{}\n", what, styled(value, shown_as, color));
  };
  Style style = Style::plain;
  if (rollout.state == "refused") style = Style::bad;
  if (rollout.state == "in-force") style = Style::good;
  line("rollout", rollout.state, style);
  line("why", printable(rollout.why));
  if (!rollout.current.empty())
    line("in force",
         fmt::format("{} (generation {}){}", printable(rollout.current.substr(0, shown)),
                     rollout.generation, rollout.open ? "" : ", not open yet"));
  line("this gateway", printable(rollout.description.substr(0, shown)));
  line("before", printable(rollout.former.substr(0, shown)));
  if (!rollout.next.empty())
    line("judged", fmt::format("{}, proposed by {}", printable(rollout.next.substr(0, shown)),
                               printable(rollout.by)));
  for (const std::string& gateway : rollout.waiting) line("waits for", printable(gateway));
  return text;
}

}  // namespace mlcca::tools
