// SPDX-License-Identifier: BSD-2-Clause
// What the comments of a description say that a check finds.
#pragma once
#include <set>
#include <string>

#include "tests/description/twin/twin.hpp"

namespace mlcca::testing {

/// The text of a file that is read whole.
std::string text_of(const std::string& path);

/// The findings that both checkers know, as numbers:
///   <!-- expect: MLCCA010 SUBSCRIBER -->
///   <!-- expect: MLCCA021 PUBLISHER SUBSCRIBER HOP ATTRIBUTE REQUIRED PROVIDED -->
/// MLCCA020 likewise with "-" as hop; what is missing is not-provided.
Keys expected_in(const std::string& text);

/// The other ones, as "MLCCA028 PUBLISHER", or with the channel where a finding has no publisher.
std::set<std::string> others_expected_in(const std::string& text);

/// Those of the C++ checker, in the same form.
std::set<std::string> others_of(core::System system);

/// One a line, for messages.
std::string listed(const Keys& keys);

}  // namespace mlcca::testing
