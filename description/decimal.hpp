// SPDX-License-Identifier: BSD-2-Clause
// Exact decimal arithmetic on digits: the point is moved, then the rest decides the rounding.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "mlcca/attribute.hpp"

namespace mlcca::description {

enum class Rounding : std::uint8_t { down, up };

/// `decimal` (digits, optionally a point and more digits) times 10^shift as a whole number, rounded
/// once. Nothing if it does not fit below kUnbounded.
std::optional<Value> scaled(std::string_view decimal, int shift, Rounding rounding);

}  // namespace mlcca::description
