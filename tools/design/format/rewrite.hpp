// SPDX-License-Identifier: BSD-2-Clause
// Lists of attributes from one form into the other. All else of the text stays as it is, byte by
// byte.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools::design {

enum class Form : std::uint8_t { brief, paper };

/// An attribute that is built in and stays an element, and why.
struct Kept {
  int line = 0;
  std::string name;
  std::string_view why;
};

struct Rewritten {
  std::string text;
  std::size_t attributes = 0;  ///< that have the other form now
  std::vector<Kept> kept;
};

/// A text that the schema accepts, with its lists in that form. Values are exact. An Attribute
/// stays an element if no unit says its value exactly, a comment stands in it, before it or behind
/// it on its line, it alone is or is not dynamic, or its list has it already. A text in that form,
/// and the result, are left as they are.
Rewritten rewritten(std::string text, Form form);

}  // namespace mlcca::tools::design
