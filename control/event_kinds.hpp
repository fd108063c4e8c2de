// SPDX-License-Identifier: BSD-2-Clause
// What is known of each kind of event: see control/event_kinds.inc.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace mlcca::control {

/// What an event says about a delivery. A withdrawal is a refusal of what was granted.
enum class EventVerdict : std::uint8_t { none, granted, refused, withdrawal };
/// How tools show an event.
enum class Tone : std::uint8_t { plain, good, warning, bad };
/// Which decisions may be others after an event.
enum class Decides : std::uint8_t { nothing, subject, all };
/// Whom an event concerns that names no subject.
enum class Reach : std::uint8_t { subject, everyone };

struct EventKind {
  const char* name;
  Tone tone;
  Decides decides;
  const char* message_id = nullptr;  ///< null: it is for clients alone, and in no log
  EventVerdict verdict = EventVerdict::none;
  Reach reach = Reach::subject;
};

/// In the order of control/event_kinds.inc: those for clients alone are the last ones.
inline constexpr std::array kEventKinds{
#define MLCCA_EVENT(identifier, name, message_id, verdict, tone, decides, reach, meaning, cause) \
  EventKind{name, Tone::tone, Decides::decides, message_id, EventVerdict::verdict, Reach::reach},
#define MLCCA_CLIENT_EVENT(name, tone, decides, meaning, cause) \
  EventKind{name, Tone::tone, Decides::decides},
#include "control/event_kinds.inc"
};

/// Null if there is no such kind: events of later versions are passed on as they are.
constexpr const EventKind* event_kind(std::string_view name) {
  const auto* const at = std::ranges::find(kEventKinds, name, &EventKind::name);
  return at == kEventKinds.end() ? nullptr : at;
}

}  // namespace mlcca::control
