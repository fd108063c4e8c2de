// SPDX-License-Identifier: BSD-2-Clause
// Replies of mlccad as JSON for programs: one object on one line with a newline at its end.
#pragma once
#include <string>
#include <vector>

#include "control/messages.hpp"

namespace mlcca::tools {

/// The fields of the message under their names in control.proto, with numbers in its units.
/// Subjects are strings ("0xa4efeccc3210b497"), 2^64-1 is "unbounded", and a value that is not
/// known is null. An Error becomes {"error": {"kind": …, "message": …, "details": […]}}.
std::string to_json(const control::Reply& reply);

/// The output of `status --check`: {"health": {"state": "degraded", "reasons": [...], "left_out":
/// 0}}.
std::string to_json(const control::Health& of_status);

/// The gates, each with the fields "hook", "drops_early", "ingress" and "egress" of its interface
/// if that is among `interfaces`.
std::string to_json(const control::Gates& gates, const std::vector<control::Interface>& interfaces);

}  // namespace mlcca::tools
