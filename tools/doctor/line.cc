// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace mlcca::doctor {
namespace {

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::ok:
      return "ok";
    case Outcome::failed:
      return "FAILED";
    case Outcome::not_tested:
      return "not tested";
  }
  std::unreachable();
}

std::size_t lines_with(std::span<const Line> lines, Outcome outcome) {
  return static_cast<std::size_t>(std::ranges::count(lines, outcome, &Line::outcome));
}

}  // namespace

bool any_failed(std::span<const Line> lines) { return lines_with(lines, Outcome::failed) != 0; }

std::string to_text(std::span<const Line> lines) {
  std::string out;
  std::size_t width = 0;
  for (const Line& line : lines) width = std::max(width, line.check.size());
  for (const Line& line : lines)
    out += fmt::format("{:<{}}  {}: {}\n", line.check, width, name_of(line.outcome), line.text);
  return out + fmt::format("{} ok, {} failed, {} not tested\n", lines_with(lines, Outcome::ok),
                           lines_with(lines, Outcome::failed),
                           lines_with(lines, Outcome::not_tested));
}

bool was_tried(std::span<const Line> lines) {
  return std::ranges::any_of(lines, [](const Line& line) {
    return line.outcome != Outcome::not_tested &&
           (line.check == "echo" || line.check == "bit rate measured" ||
            line.check == "queue depth");
  });
}

std::string to_json(const std::string& interface, std::span<const Line> lines) {
  nlohmann::ordered_json checks = nlohmann::ordered_json::array();
  for (const Line& line : lines)
    checks.push_back(
        {{"check", line.check}, {"outcome", name_of(line.outcome)}, {"text", line.text}});
  const nlohmann::ordered_json all = {{"interface", interface},
                                      {"ok", lines_with(lines, Outcome::ok)},
                                      {"failed", lines_with(lines, Outcome::failed)},
                                      {"not_tested", lines_with(lines, Outcome::not_tested)},
                                      {"checks", checks}};
  return all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace mlcca::doctor
