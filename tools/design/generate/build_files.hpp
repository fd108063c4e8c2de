// SPDX-License-Identifier: BSD-2-Clause
// Snippets for Make and CMake: what was generated, and how it is generated again.
#pragma once
#include <string>
#include <vector>

#include "tools/design/generate/unit.hpp"

namespace mlcca::tools::design {

struct BuildFiles {
  std::string make;   ///< mlcca_generated.mk
  std::string cmake;  ///< mlcca_generated.cmake
};

/// `only` is what --component named. Files that the description includes are named relative to it;
/// those elsewhere are left out, because no path may get into generated text.
BuildFiles build_files(const core::System& system, const std::vector<Unit>& units,
                       const std::vector<std::string>& only);

}  // namespace mlcca::tools::design
