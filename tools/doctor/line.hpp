// SPDX-License-Identifier: BSD-2-Clause
// The output of doctor: a line for each check.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace mlcca::doctor {

enum class Outcome : std::uint8_t { ok, failed, not_tested };

/// The result of a check with an explanation.
struct Line {
  std::string check;
  Outcome outcome = Outcome::ok;
  std::string text;
  bool operator==(const Line&) const = default;
};

[[nodiscard]] bool any_failed(std::span<const Line> lines);
/// Whether one of the checks that need --send was made.
[[nodiscard]] bool was_tried(std::span<const Line> lines);
/// Lines such as "echo         FAILED: …", then a line with the counts.
[[nodiscard]] std::string to_text(std::span<const Line> lines);
/// The lines as a JSON object on one line.
[[nodiscard]] std::string to_json(const std::string& interface, std::span<const Line> lines);

}  // namespace mlcca::doctor
