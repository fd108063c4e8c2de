// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <filesystem>

namespace mlcca::testing {

/// The folder of the whole project, as an absolute path.
inline std::filesystem::path source_tree() {
  const std::filesystem::path here = __FILE__;
  return std::filesystem::absolute(here.parent_path() / ".." / "..").lexically_normal();
}

}  // namespace mlcca::testing
