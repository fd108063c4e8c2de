// SPDX-License-Identifier: BSD-2-Clause
// What the gates have refused, with what a description would need for it.
#pragma once
#include <string>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

/// Elements for frames that no channel has, in lines, with a comment that says what was seen and
/// where each element belongs. Empty where no channel can have such frames, and of a delivery.
std::string addition(const control::Audit& audit, const control::Finding& finding);
/// Of all findings that have one, an empty line between two.
std::string additions(const control::Audit& audit);

/// "123", "0x4e6f626f64790000", "emergency-switch of switch"; empty: frames that cannot be read.
std::string name_of(const control::Finding& finding);

/// A table, and below it the additions of the first findings.
std::string render(const control::Audit& audit, Color color);

}  // namespace mlcca::tools
