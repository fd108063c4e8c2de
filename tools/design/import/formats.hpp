// SPDX-License-Identifier: BSD-2-Clause
// The formats that can be imported, a row each.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

struct ImportFormat {
  std::string_view name;
  /// Whether a file seems to be one; the first format that says so is taken.
  bool (*is)(std::string_view text);
  /// `file` is its name in errors.
  Result<ImportedNetwork> (*read)(std::string_view text, const std::string& file,
                                  const ImportOptions& options);
};

/// nullptr: none.
const ImportFormat* recognise(std::string_view text);
const ImportFormat* format_called(std::string_view name);
std::vector<std::string> format_list();
/// "dbc, eds, ..."
std::string format_names();
/// Of a text in none of these: what it is, and what to do with it.
std::string reason_of(std::string_view text);

}  // namespace mlcca::tools::design
