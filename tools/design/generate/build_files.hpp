// SPDX-License-Identifier: BSD-2-Clause
// Snippets for Make and CMake that list the generated files and the command that generates them.
#pragma once
#include <string>
#include <vector>

#include "tools/design/generate/unit.hpp"

namespace mlcca::tools::design {

/// The contents of the two snippets.
struct BuildFiles {
  std::string make;   ///< mlcca_generated.mk
  std::string cmake;  ///< mlcca_generated.cmake
};

/// `only` are the names given with --component. Included files are named relative to the
/// description; those outside its folder are left out, because generated text must not contain
/// paths of a machine.
BuildFiles build_files(const core::System& system, const std::vector<Unit>& units,
                       const std::vector<std::string>& only);

}  // namespace mlcca::tools::design
