// SPDX-License-Identifier: BSD-2-Clause
// What the gates have refused, with what a description would need for it.
#pragma once
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

/// For each finding the elements that it lacks, in lines, with a comment that says what was seen
/// and where each belongs. Findings of one subject share its channel, which the first of them has.
/// Empty where no channel can have such frames, where former additions have it, and of a delivery.
std::vector<std::string> additions_of(const control::Audit& audit);
/// Those that are not empty, an empty line between two.
std::string additions(const control::Audit& audit);

/// "123", "0x4e6f626f64790000", "emergency-switch of switch"; empty: frames that cannot be read.
std::string name_of(const control::Finding& finding);
/// Of a delivery: what to do where its frames are wanted, in a line; empty: nothing to advise.
std::string advice(const control::Finding& finding);
/// "192.0.2.7 (02:00:5e:10:00:01)", "node 23"; empty: not known.
std::string sender_of(const control::Finding& finding);

/// A table, and below it the additions of the first findings.
std::string render(const control::Audit& audit, Color color);

}  // namespace mlcca::tools
