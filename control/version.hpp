// SPDX-License-Identifier: BSD-2-Clause
// The version of the product, which the daemon and all tools state.
#pragma once

namespace mlcca {

inline constexpr const char kVersion[] = "0.1.0";

}  // namespace mlcca
