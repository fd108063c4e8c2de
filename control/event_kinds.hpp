// SPDX-License-Identifier: BSD-2-Clause
// What is known of each kind of event: see control/event_kinds.inc.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace mlcca::control {

/// How tools show an event.
enum class Tone : std::uint8_t { plain, good, warning, bad };
/// Which decisions may be others after an event.
enum class Decides : std::uint8_t { nothing, subject, all };

struct EventKind {
  std::string_view name;
  Tone tone;
  Decides decides;
  bool is_withdrawal = false;  ///< what was granted is refused
  bool of_everyone = false;    ///< it concerns every channel, unless it names a subject
};

inline constexpr std::array kEventKinds{
#define MLCCA_EVENT(identifier, name, message_id, verdict, tone, decides, reach, client)    \
  EventKind{name, Tone::tone, Decides::decides, std::string_view(#verdict) == "withdrawal", \
            std::string_view(#reach) == "everyone"},
#define MLCCA_CLIENT_EVENT(name, tone, decides, client) \
  EventKind{name, Tone::tone, Decides::decides},
#include "control/event_kinds.inc"
};

/// Null if there is no such kind: events of later versions are passed on as they are.
constexpr const EventKind* event_kind(std::string_view name) {
  const auto* const at = std::ranges::find(kEventKinds, name, &EventKind::name);
  return at == kEventKinds.end() ? nullptr : at;
}

}  // namespace mlcca::control
