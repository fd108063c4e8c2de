// SPDX-License-Identifier: BSD-2-Clause
// Random descriptions whose networks state little and have it computed: buses with a bit rate,
// meshes with links, in several ways, with attribute sets and user-defined attributes.
#pragma once
#include <cstdint>
#include <string>

namespace mlcca::testing {

/// A description that fits the schema and has no problem. The same for the same seed; the System is
/// called "s" with the seed behind it.
std::string random_system(std::uint64_t seed);

}  // namespace mlcca::testing
