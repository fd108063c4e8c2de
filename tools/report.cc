// SPDX-License-Identifier: BSD-2-Clause
#include "tools/report.hpp"

#include <fmt/format.h>

#include <string_view>

namespace mlcca::tools {
namespace {

#include "report_page.inc"

/// JSON has '<' in strings only: there nothing of the daemon can end the element that it stands in.
std::string for_markup(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json)
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  return out;
}

}  // namespace

std::string report_page(const std::vector<std::pair<std::string, std::string>>& answers,
                        std::uint64_t taken_unix_ns) {
  std::string page(kBefore);
  const char* separator = "{";
  for (const auto& [verb, json] : answers) {
    std::string object = for_markup(json);
    if (verb == "status") object.insert(1, fmt::format("\"taken_unix_ns\":{},", taken_unix_ns));
    page += fmt::format("{}\"{}\":{}", separator, verb, object);
    separator = ",";
  }
  page += '}';
  page += kBehind;
  return page;
}

}  // namespace mlcca::tools
