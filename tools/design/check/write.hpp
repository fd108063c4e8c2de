// SPDX-License-Identifier: BSD-2-Clause
// The output forms of a report.
#pragma once
#include <string>

#include "tools/design/check/report.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

/// "FILE:LINE: error MLCCA021: text", without the hint.
[[nodiscard]] std::string line_of(const ReportedFinding& finding, Color color);

/// Text: lines "FILE:LINE: error MLCCA021: text" with a hint below each, then a summary.
std::string write_text(const Report& report, Color color);

/// JSON: one object on one line, {"version", "systems": [{"file", "name", "channels", …}],
/// "findings": [{"id", "severity", "name", "file", "line", "text", "hint", "channel", "publisher",
/// "subscriber", "place", "attribute", "required", "provided"}], "errors", "warnings", "notes"}. A
/// finding has only the fields that apply.
std::string write_json(const Report& report);

/// SARIF 2.1.0, which editors and code hosting services read.
std::string write_sarif(const Report& report);

/// A self-contained HTML page: complete tables, and a script that draws the networks.
std::string write_html(const Report& report);

}  // namespace mlcca::tools::design
