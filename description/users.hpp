// SPDX-License-Identifier: BSD-2-Clause
// Users of this machine.
#pragma once
#include <cstdint>
#include <expected>
#include <string>

namespace mlcca::description {

/// The number of a user who is given by name or number. The error says what is wrong; 2^32 - 1 is
/// nobody's number.
std::expected<std::uint32_t, std::string> uid_of(const std::string& user);

}  // namespace mlcca::description
