// SPDX-License-Identifier: BSD-2-Clause
// The program dot of Graphviz, which turns a graph into a drawing.
#pragma once
#include <chrono>
#include <string>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// The <svg> element that `program` (looked up in PATH) draws of `source`, without XML declaration
/// and DOCTYPE: it can stand in an HTML page. The error says in words why there is none: the
/// program is missing, fails, needs longer than `patience`, or draws more than 16 MiB.
Result<std::string> draw_svg(const std::string& source, const char* program = "dot",
                             std::chrono::milliseconds patience = std::chrono::seconds(20));

}  // namespace mlcca::tools::design
