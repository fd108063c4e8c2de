// SPDX-License-Identifier: BSD-2-Clause
// Replies of mlccad for a person: text that ends with a newline, or nothing.
#pragma once
#include <string>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

std::string render(const control::Status& status, Color color);
std::string render(const control::Networks& networks, Color color);

/// An overview: one line for each delivery.
std::string render(const control::Channels& channels, Color color);

/// Each delivery with its verdict, a line for each attribute, the route, and, `with_counters`, the
/// frames that passed and were dropped.
std::string explain(const control::Channels& channels, Color color, bool with_counters);

std::string render(const control::Done& done, Color color);

/// One line.
std::string render(const control::Event& event, Color color);

/// "mlccactl: " and the message, then a line for each detail.
std::string render(const control::Error& error, Color color);

}  // namespace mlcca::tools
