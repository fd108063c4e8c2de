// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>

namespace mlcca::core {

/// Stands for "no file": the thing came at run time and is not in the description.
inline constexpr std::uint32_t kNoFile = 0xffffffff;

/// Where something was declared, for messages about errors.
struct Origin {
  std::uint32_t file = kNoFile;  ///< index into System::files
  int line = 0;
  bool operator==(const Origin&) const = default;
};

}  // namespace mlcca::core
