// SPDX-License-Identifier: BSD-2-Clause
// The table of the formats that can be imported.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

/// What an option of the command line states, and only some formats take.
enum class Takes : std::uint8_t { node, profile, bitrate, data_bitrate };

struct ImportFormat {
  std::string_view name;
  std::span<const Takes> takes;
  /// Whether a text seems to have this format. The first format for which this is true is used.
  bool (*is)(std::string_view text);
  /// Reads a text. `file` is its name in errors.
  Result<ImportedNetwork> (*read)(std::string_view text, const std::string& file,
                                  const ImportOptions& options);
};

/// The format of a text, or the one with a name; nullptr if there is none.
const ImportFormat* recognise(std::string_view text);
const ImportFormat* format_called(std::string_view name);
std::vector<std::string> format_list();
/// The names of all formats: "dbc, eds, ..."
std::string format_names();
/// For a text that has none of these formats: what it is, and what the user can do.
std::string reason_of(std::string_view text);

}  // namespace mlcca::tools::design
