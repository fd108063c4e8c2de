// SPDX-License-Identifier: BSD-2-Clause
// Phrases that several outputs for people share.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

/// The cell "granted" or "refused".
Cell verdict_cell(bool granted);

Style style_of_event(std::string_view kind);

/// The line "health       DEGRADED", then a line for each reason.
std::string health_lines(const control::Health& health, Color color);

/// The sender of an unknown frame as far as it is known: "10.0.0.7 (02:00:5e:10:00:01)".
std::string print_sender(const control::Unknown& frame);

/// Rates and times in the units of the messages, printed with at most three decimals.
std::string bytes_per_second(std::uint64_t rate);
std::string bits_per_second(std::uint64_t rate);
/// The share `parts` of `whole` as "12.5 %"; `whole` must not be 0.
std::string percent(std::uint64_t parts, std::uint64_t whole);

/// The rate of the links of `use` one after another: "7.543 Mbit/s".
std::string path_rate(const control::MediumUse& use);

/// The places of a route: "laptop > relay > control".
std::string way(const std::vector<std::string>& places);

/// What a bus or mesh gives a channel: "response 310 us, at most 5 ms guaranteed" or "path laptop >
/// relay > control, path rate 7.543 Mbit/s, 600 kB/s left in all links". Empty for a network
/// that is neither.
std::string describe(const control::MediumUse& use);

/// Which attribute set is in use: "2 of 3", where 1 is the preferred one; "none of 3" if refused;
/// empty if the channel has only one set.
std::string set_in_use(const control::Channel& channel);

}  // namespace mlcca::tools
