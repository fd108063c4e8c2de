// SPDX-License-Identifier: BSD-2-Clause
// Reads <Bus> and <Mesh>, which describe a medium itself.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "description/draft.hpp"

namespace mlcca::description {

/// Reads a <Bus> that the schema has accepted. What else is wrong with it is reported and left out.
core::CanBus read_bus(const Element& e, Problems& problems);

/// Reads a <Mesh> in the same way.
MeshDraft read_mesh(const Element& e, Problems& problems);

/// Normalises an address for comparisons: a MAC address in lower case with leading zeros, or an IP
/// address as inet_ntop() writes it. Nullopt if it is neither.
std::optional<std::string> normal_address(std::string_view address);

}  // namespace mlcca::description
