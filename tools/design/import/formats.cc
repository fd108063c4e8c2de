// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/formats.hpp"

#include <algorithm>
#include <array>

#include "tools/design/import/dbc.hpp"
#include "tools/design/import/eds.hpp"

namespace mlcca::tools::design {
namespace {

/// Some line begins with that.
bool has_line(std::string_view text, std::string_view begin) {
  for (auto at = text.find(begin); at != std::string_view::npos; at = text.find(begin, at + 1))
    if (at == 0 || text[at - 1] == '\n') return true;
  return false;
}

bool is_dbc(std::string_view text) { return has_line(text, "BO_ ") || has_line(text, "BU_"); }

bool is_eds(std::string_view text) {
  return has_line(text, "[DeviceInfo]") || has_line(text, "[FileInfo]");
}

constexpr auto kFormats = std::to_array<ImportFormat>({
    {"dbc", is_dbc, import_dbc},
    {"eds", is_eds, import_eds},
});

}  // namespace

const ImportFormat* recognise(std::string_view text) {
  const auto* const found =
      std::ranges::find_if(kFormats, [&](const ImportFormat& format) { return format.is(text); });
  return found == kFormats.end() ? nullptr : &*found;
}

const ImportFormat* format_called(std::string_view name) {
  const auto* const found = std::ranges::find(kFormats, name, &ImportFormat::name);
  return found == kFormats.end() ? nullptr : &*found;
}

std::vector<std::string> format_list() {
  std::vector<std::string> out;
  out.reserve(kFormats.size());
  for (const auto& format : kFormats) out.emplace_back(format.name);
  return out;
}

std::string format_names() {
  std::string out;
  for (const auto& format : kFormats) out += (out.empty() ? "" : ", ") + std::string(format.name);
  return out;
}

}  // namespace mlcca::tools::design
