// SPDX-License-Identifier: BSD-2-Clause
// The tables of the HTML report: each is complete HTML, or empty where there is nothing to show.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tools/design/check/report.hpp"

namespace mlcca::tools::design {

/// Rows of one table; more are counted, not shown.
inline constexpr std::size_t kMaxRows = 2000;

/// Those of one severity, in the order of the report.
std::string findings_table(const std::vector<ReportedFinding>& findings, core::Severity severity);

/// What does not fit first, then what is decided at run time, then the others.
std::string channels_table(const SystemReport& system);

/// With what is reserved of each network's capacity, where it states one.
std::string networks_table(const SystemReport& report);

std::string user_attributes_table(const core::System& system);

}  // namespace mlcca::tools::design
