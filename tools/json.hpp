// SPDX-License-Identifier: BSD-2-Clause
// Replies of mlccad for programs: one JSON object, on one line that ends with a newline.
#pragma once
#include <string>
#include <vector>

#include "control/messages.hpp"

namespace mlcca::tools {

/// The fields of the message under the names of control.proto, numbers in its units. Subjects are
/// strings ("0xa4efeccc3210b497"), "unbounded" stands for 2^64-1, null for what is not known.
/// An Error is {"error": {"kind": …, "message": …, "details": […]}}.
std::string to_json(const control::Reply& reply);

/// Of `status --check`: {"health": {"state": "degraded", "reasons": [...], "left_out": 0}}.
std::string to_json(const control::Health& of_status);

/// Each gate also with what the status reports of its interface: "hook", "drops_early", "ingress"
/// and "egress".
std::string to_json(const control::Gates& gates, const std::vector<control::Interface>& interfaces);

}  // namespace mlcca::tools
