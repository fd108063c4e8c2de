// SPDX-License-Identifier: BSD-2-Clause
// Why a gate passes or drops a frame, as the kernel counts it and reports name it.
// frame_reasons.inc lists the reasons.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::core {

enum class FrameReason : std::uint8_t {
// An enumerator cannot be in parentheses.
#define FRAME_REASON(number, word, WORD, name, kind, text) \
  word = number,  // NOLINT(bugprone-macro-parentheses)
#include "core/gates/frame_reasons.inc"
#undef FRAME_REASON
};

/// What a reason says about a frame.
enum class FrameReasonKind : std::uint8_t {
  passes,   ///< it is no reason to drop
  subject,  ///< no slot has its subject
  sender,   ///< it names an admitted subject, and is not the granted sender's
  grant,    ///< the granted sender sent it, and it differs from the grant
  excess,   ///< the granted sender sent it, and it is more than was granted
  part,     ///< it continues what was not admitted
  any,      ///< its subject does not matter, or cannot be read: no slot counts it
};

struct FrameReasonRow {
  FrameReason reason;
  std::string_view name;  ///< in reports, JSON and metrics
  FrameReasonKind kind;
  std::string_view text;  ///< what it means, a clause
};

/// All reasons, each at the index that is its number.
inline constexpr auto kFrameReasons = std::to_array<FrameReasonRow>({
#define FRAME_REASON(number, word, WORD, name, kind, text) \
  {FrameReason::word, name, FrameReasonKind::kind, text},
#include "core/gates/frame_reasons.inc"
#undef FRAME_REASON
});

constexpr const FrameReasonRow& row_of(FrameReason reason) {
  return kFrameReasons.at(static_cast<std::size_t>(reason));
}

constexpr std::string_view to_text(FrameReason reason) { return row_of(reason).name; }

/// The reason of that name; nullopt if no reason has it.
constexpr std::optional<FrameReason> frame_reason(std::string_view name) {
  const auto* const row = std::ranges::find(kFrameReasons, name, &FrameReasonRow::name);
  return row == kFrameReasons.end() ? std::nullopt : std::optional(row->reason);
}

constexpr bool is_drop(FrameReason reason) {
  return row_of(reason).kind != FrameReasonKind::passes;
}
/// Whether such frames name an admitted subject and are not the granted sender's.
constexpr bool is_of_sender(FrameReason reason) {
  return row_of(reason).kind == FrameReasonKind::sender;
}
/// Whether such frames had the granted identifier and source.
constexpr bool is_of_publisher(FrameReason reason) {
  const FrameReasonKind kind = row_of(reason).kind;
  return kind == FrameReasonKind::grant || kind == FrameReasonKind::excess;
}

/// The reason of one or more frames that differ from a grant, as findings state it in words.
struct StatedReason {
  std::optional<FrameReason> reason;  ///< nullopt: it is not known which
  bool is_latest = false;             ///< only that of the latest frame is known
  auto operator<=>(const StatedReason&) const = default;
};

inline constexpr std::string_view kLatestReason = "cause not known, the latest: ";
inline constexpr std::string_view kReasonNotKnown = "not as granted";
/// Follows the name of a reason and precedes what explains it.
inline constexpr std::string_view kReasonExplained = ": ";

[[nodiscard]] inline std::string to_text(const StatedReason& stated) {
  if (!stated.reason) return std::string(kReasonNotKnown);
  return std::string(stated.is_latest ? kLatestReason : "").append(to_text(*stated.reason));
}

/// Reads what to_text() has made, also with an explanation behind it. A text that no daemon of this
/// version writes has no reason.
[[nodiscard]] constexpr StatedReason stated_reason(std::string_view text) {
  StatedReason out;
  out.is_latest = text.starts_with(kLatestReason);
  if (out.is_latest) text.remove_prefix(kLatestReason.size());
  out.reason = frame_reason(text.substr(0, text.find(kReasonExplained)));
  return out;
}

}  // namespace mlcca::core
