// SPDX-License-Identifier: BSD-2-Clause
#pragma once

namespace mlcca {
inline constexpr const char* kVersion = "0.1.0";
}  // namespace mlcca
