// SPDX-License-Identifier: BSD-2-Clause
// <Bus> and <Mesh>: what a description says of a medium itself.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "description/draft.hpp"

namespace mlcca::description {

/// A <Bus> that the schema accepts. What else is wrong with it is reported and left out.
core::CanBus read_bus(const Element& e, Problems& problems);

/// The same of a <Mesh>.
MeshDraft read_mesh(const Element& e, Problems& problems);

/// The address in the one notation that is compared: a MAC in lower case with leading zeros, an IP
/// address as inet_ntop writes it. Nothing if it is neither.
std::optional<std::string> normal_address(std::string_view address);

}  // namespace mlcca::description
