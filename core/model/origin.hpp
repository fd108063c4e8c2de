// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>

namespace mlcca::core {

/// The file of what was not described but came at run time.
inline constexpr std::uint32_t kNoFile = 0xffffffff;

/// Where something was declared, for error texts.
struct Origin {
  std::uint32_t file = kNoFile;  ///< index into System::files
  int line = 0;
  bool operator==(const Origin&) const = default;
};

}  // namespace mlcca::core
