// SPDX-License-Identifier: BSD-2-Clause
// Lists of attributes as a person might write them: in the form of the paper, in the short one, or
// with some attributes in each. Made by looking at the text, without a line of the product.
#pragma once
#include <cstdint>
#include <string>

namespace mlcca::testing {

/// `text` without comments, with half of its lists in the short form or mixed, the same for the
/// same seed. What it means stays the same.
std::string in_some_forms(const std::string& text, std::uint64_t seed);

}  // namespace mlcca::testing
