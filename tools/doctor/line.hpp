// SPDX-License-Identifier: BSD-2-Clause
// What doctor says: a line for each check.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace mlcca::doctor {

enum class Outcome : std::uint8_t { ok, failed, not_tested };

struct Line {
  std::string check;
  Outcome outcome = Outcome::ok;
  std::string text;
  bool operator==(const Line&) const = default;
};

[[nodiscard]] bool any_failed(std::span<const Line> lines);
/// One of the checks that send could be made.
[[nodiscard]] bool was_tried(std::span<const Line> lines);
/// "echo         FAILED: …", then a line with the sums.
[[nodiscard]] std::string to_text(std::span<const Line> lines);
/// One object on one line.
[[nodiscard]] std::string to_json(const std::string& interface, std::span<const Line> lines);

}  // namespace mlcca::doctor
