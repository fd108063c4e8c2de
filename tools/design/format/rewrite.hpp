// SPDX-License-Identifier: BSD-2-Clause
// Converts lists of attributes between the short form and the paper's. All other bytes of the text
// stay.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools::design {

enum class Form : std::uint8_t { brief, paper };

/// A built-in attribute that stays an element, and the reason.
struct Kept {
  int line = 0;
  std::string name;
  std::string_view why;
};

/// A converted text.
struct Rewritten {
  std::string text;
  std::size_t attributes = 0;  ///< the number of attributes that were converted
  std::vector<Kept> kept;
};

/// Converts the lists of a text that is valid by the schema; values stay exact. An attribute stays
/// an element if no unit expresses its value exactly, if a comment is in it, before it or behind it
/// on the line, if it alone is or is not dynamic, or if its list states it twice. The conversion is
/// idempotent.
Rewritten rewritten(std::string text, Form form);

}  // namespace mlcca::tools::design
