// SPDX-License-Identifier: BSD-2-Clause
// The constant parts of the page, generated from cockpit/ and the files beside this one.
#pragma once
#include <string_view>

namespace mlcca::tools::design {

[[nodiscard]] std::string_view page_style();
/// The script that draws the networks, without its data.
[[nodiscard]] std::string_view page_script();
/// "sha256-…": the page permits (Content-Security-Policy) only the script with this hash.
[[nodiscard]] std::string_view page_script_hash();

}  // namespace mlcca::tools::design
