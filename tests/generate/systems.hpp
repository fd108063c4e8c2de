// SPDX-License-Identifier: BSD-2-Clause
// Descriptions that code is generated from.
#pragma once
#include <string>

namespace mlcca::test {

/// Robot with a switch and motors on one bus, and a lamp on a second one behind a gateway. `lost`
/// is how many events in a row the bus may lose; the motors stand 2.
std::string robot(const std::string& lost = "0");

/// Names that are keywords, macros, alike, or bare subjects; descriptions that try to end a
/// comment; the largest and smallest values; user-defined attributes; several attribute sets.
std::string nasty();

}  // namespace mlcca::test
