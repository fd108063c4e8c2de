// SPDX-License-Identifier: BSD-2-Clause
// The version of the whole product, as daemon and tools state it.
#pragma once

namespace mlcca {

inline constexpr const char kVersion[] = "0.1.0";

}  // namespace mlcca
