// SPDX-License-Identifier: BSD-2-Clause
// Text about decisions: those that assumed changes would cause, and past ones.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <ranges>
#include <vector>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "tools/render.hpp"
#include "tools/times.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

/// The effects of a change on a delivery, in the order of printing.
enum class Effect : std::uint8_t { lost, degraded, upgraded, gained, same };
constexpr std::size_t kEffects = 5;

Effect effect_of(const control::Outlook& outlook) {
  if (loses(outlook)) return Effect::lost;
  if (!outlook.granted_then) return Effect::same;
  if (!outlook.granted_now) return Effect::gained;
  if (outlook.set_then > outlook.set_now) return Effect::degraded;
  return outlook.set_then < outlook.set_now ? Effect::upgraded : Effect::same;
}

Cell cell_of(Effect effect) {
  switch (effect) {
    case Effect::lost:
      return {"lost", Style::bad};
    case Effect::degraded:
      return {"degraded", Style::warning};
    case Effect::upgraded:
      return {"upgraded", Style::good};
    case Effect::gained:
      return {"gained", Style::good};
    case Effect::same:
      break;
  }
  return {"as now"};
}

/// "granted", "refused" or, unless the preferred set is in use now and then, the number of the set.
std::string state(const control::Outlook& outlook, bool granted, std::uint32_t set) {
  if (!granted) return "refused";
  return outlook.set_now == 0 && outlook.set_then == 0 ? "granted" : fmt::format("set {}", set + 1);
}

}  // namespace

bool loses(const control::Outlook& outlook) { return outlook.granted_now && !outlook.granted_then; }

std::string render(const control::WhatIf& what_if, Color color) {
  if (what_if.outlooks.empty())
    return "nothing would change; " + many(what_if.unchanged, "delivery is as it is now\n",
                                           "deliveries are as they are now\n");
  auto outlooks = what_if.outlooks;
  std::ranges::stable_sort(outlooks, {}, effect_of);
  TextTable table({{"EFFECT"}, {"CHANNEL"}, {"PUBLISHER"}, {"TO"}, {"NOW"}, {"THEN"}, {"REASON"}});
  std::array<std::size_t, kEffects> counts{};
  for (const auto& outlook : outlooks) {
    const auto effect = effect_of(outlook);
    ++counts[static_cast<std::size_t>(effect)];
    table.add({cell_of(effect),
               {outlook.channel},
               {outlook.publisher},
               {outlook.to},
               {state(outlook, outlook.granted_now, outlook.set_now)},
               {state(outlook, outlook.granted_then, outlook.set_then)},
               {outlook.reason}});
  }
  const auto count = [&](Effect effect) { return counts[static_cast<std::size_t>(effect)]; };
  return table.text(color) +
         fmt::format("{} lost, {} degraded, {} upgraded, {} gained, {} as now\n",
                     count(Effect::lost), count(Effect::degraded), count(Effect::upgraded),
                     count(Effect::gained), count(Effect::same) + what_if.unchanged);
}

std::string render(const control::History& history, Color color) {
  TextTable table({{"TIME"}, {"KIND"}, {"CHANNEL"}, {"FROM"}, {"TO"}, {"NETWORK"}, {"MESSAGE"}});
  for (const auto& entry : history.entries | std::views::reverse)
    table.add({{print_moment(entry.unix_ns)},
               {entry.kind, style_of_event(entry.kind)},
               {entry.channel.empty() && entry.subject != 0 ? core::format_subject(entry.subject)
                                                            : entry.channel},
               {entry.from},
               {entry.to},
               {entry.network},
               {entry.message}});
  return table.empty() ? "nothing of that is recorded\n" : table.text(color);
}

}  // namespace mlcca::tools
