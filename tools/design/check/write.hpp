// SPDX-License-Identifier: BSD-2-Clause
// The forms in which a report is written.
#pragma once
#include <string>

#include "tools/design/check/report.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

/// For a person: "FILE:LINE: error MLCCA021: text" and the hint below, then a summary.
std::string write_text(const Report& report, Color color);

/// One object on one line: {"version", "systems": [{"file", "name", "channels", …}], "findings":
/// [{"id", "severity", "name", "file", "line", "text", "hint", "channel", "publisher",
/// "subscriber", "place", "attribute", "required", "provided"}], "errors", "warnings", "notes"}. A
/// finding has only the fields that apply.
std::string write_json(const Report& report);

/// SARIF 2.1.0, as editors and code hosts read it.
std::string write_sarif(const Report& report);

/// A page of its own: tables that are complete, and a script that draws the networks.
std::string write_html(const Report& report);

}  // namespace mlcca::tools::design
