// SPDX-License-Identifier: BSD-2-Clause
#include "tools/report.hpp"

#include <fmt/format.h>

#include <string_view>

#include "tools/escape.hpp"

namespace mlcca::tools {
namespace {

#include "report_page.inc"

}  // namespace

std::string report_page(const std::vector<std::pair<std::string, std::string>>& answers,
                        std::uint64_t taken_unix_ns) {
  std::string page(kBefore);
  const char* separator = "{";
  for (const auto& [verb, json] : answers) {
    std::string object = json_in_markup(json);
    if (verb == "status") object.insert(1, fmt::format("\"taken_unix_ns\":{},", taken_unix_ns));
    page += fmt::format("{}\"{}\":{}", separator, verb, object);
    separator = ",";
  }
  page += '}';
  page += kBehind;
  return page;
}

}  // namespace mlcca::tools
