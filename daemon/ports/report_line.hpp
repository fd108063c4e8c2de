// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <functional>
#include <string>

namespace mlcca {

/// Receives what an operator should know about an interface: its network (or an empty text), one
/// line, and whether it is a problem.
using ReportLine =
    std::function<void(const std::string& network, const std::string& line, bool problem)>;

}  // namespace mlcca
