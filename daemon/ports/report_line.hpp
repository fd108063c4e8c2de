// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <functional>
#include <string>

namespace mlcca {

/// Gets what an operator should know of an interface: its network, or none, one line, and whether
/// it is a problem.
using ReportLine =
    std::function<void(const std::string& network, const std::string& line, bool problem)>;

}  // namespace mlcca
