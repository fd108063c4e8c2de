// SPDX-License-Identifier: BSD-2-Clause
// What a check of a description can find: stable numbers, severities, titles.
#pragma once
#include <cstdint>

namespace mlcca::core {

/// Printed as MLCCA and three digits. Numbers are never used again for something else.
enum class FindingId : std::uint16_t {
  // The description cannot be used (exit status 2).
  unreadable = 1,     ///< a file cannot be opened or read
  not_xml = 2,        ///< syntax, encoding, DTD, limits
  not_in_schema = 3,  ///< elements, attributes or values that the schema does not know
  rule = 4,           ///< a rule of the description that has no number of its own
};

}  // namespace mlcca::core
