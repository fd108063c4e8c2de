// SPDX-License-Identifier: BSD-2-Clause
// The kinds of findings of a design-time check: stable numbers, severities, titles and advice.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// One value for each row of finding_rows.inc. A new kind needs such a row and the code that finds
/// it.
enum class FindingId : std::uint8_t {
// NOLINTNEXTLINE(bugprone-macro-parentheses): an enumerator
#define FINDING(number, name, severity, title, advice) name = number,
#include "core/design/finding_rows.inc"
};

/// A note is information and does not make a description unfit.
enum class Severity : std::uint8_t { error, warning, note };

/// A kind of findings, from a row of finding_rows.inc.
struct FindingInfo {
  FindingId id;
  Severity severity;
  const char* name;    ///< short and stable, for tools: "no-publisher"
  const char* title;   ///< a sentence for people, without a full stop
  const char* advice;  ///< what it means and what helps, in one or two sentences
};

/// All kinds, by number.
[[nodiscard]] std::span<const FindingInfo> finding_table();
[[nodiscard]] const FindingInfo& info(FindingId id);

/// Formats the number of a kind: "MLCCA012".
[[nodiscard]] std::string code_of(FindingId id);

/// Index that stands for "does not apply".
inline constexpr std::uint32_t kNone = 0xffffffff;

/// One problem or note. Numbers are indices into the System, or kNone.
struct Finding {
  FindingId id = FindingId::rule;
  Origin origin;
  std::string text;  ///< what is wrong, with numbers
  std::string hint;  ///< what would be right
  std::uint32_t channel = kNone;
  std::uint32_t publisher = kNone;
  std::uint32_t subscriber = kNone;
  std::uint32_t frames_of = kNone;  ///< of a short queue: the publisher of its frames
  Place place;                      ///< the hop, network or gateway; only with has_place
  bool has_place = false;
  std::string attribute;  ///< name of the failed attribute, or empty
  std::string required;   ///< value with unit, or empty
  std::string provided;   ///< value with unit, "not provided", or empty
};

}  // namespace mlcca::core
