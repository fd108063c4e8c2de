// SPDX-License-Identifier: BSD-2-Clause
// The parts of the page that are always the same: made of cockpit/ and the files beside this one.
#pragma once
#include <string_view>

namespace mlcca::tools::design {

[[nodiscard]] std::string_view page_style();
/// The drawing, and what it is fed with.
[[nodiscard]] std::string_view page_script();
/// "sha256-…", by which a browser knows the script: it runs no other one.
[[nodiscard]] std::string_view page_script_hash();

}  // namespace mlcca::tools::design
