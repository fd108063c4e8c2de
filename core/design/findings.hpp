// SPDX-License-Identifier: BSD-2-Clause
// What a check of a description can find: stable numbers, severities, titles and advice.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// A value for each row of finding_rows.inc, which is all that a new kind needs beside the code
/// that finds it.
enum class FindingId : std::uint8_t {
// NOLINTNEXTLINE(bugprone-macro-parentheses): an enumerator
#define FINDING(number, name, severity, title, advice) name = number,
#include "core/design/finding_rows.inc"
};

/// A note is information: it does not make a description unfit.
enum class Severity : std::uint8_t { error, warning, note };

struct FindingInfo {
  FindingId id;
  Severity severity;
  const char* name;    ///< short and stable, for tools: "no-publisher"
  const char* title;   ///< one sentence for people, without a full stop
  const char* advice;  ///< what it means and what helps, in a sentence or two
};

/// All of them, by number.
[[nodiscard]] std::span<const FindingInfo> finding_table();
[[nodiscard]] const FindingInfo& info(FindingId id);

/// "MLCCA012"
[[nodiscard]] std::string code_of(FindingId id);

inline constexpr std::uint32_t kNone = 0xffffffff;

/// One thing that is wrong, or worth knowing. Numbers are indices into the System, kNone where they
/// do not apply.
struct Finding {
  FindingId id = FindingId::rule;
  Origin origin;
  std::string text;  ///< what is wrong, with the numbers
  std::string hint;  ///< what would be right
  std::uint32_t channel = kNone;
  std::uint32_t publisher = kNone;
  std::uint32_t subscriber = kNone;
  std::uint32_t frames_of =
      kNone;    ///< a queue that is too short: the publisher whose frames it has
  Place place;  ///< hop, network or gateway; meaningful with has_place
  bool has_place = false;
  std::string attribute;  ///< name of the attribute that failed, or empty
  std::string required;   ///< value with unit, or empty
  std::string provided;   ///< value with unit, "not provided", or empty
};

}  // namespace mlcca::core
