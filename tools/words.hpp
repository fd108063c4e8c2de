// SPDX-License-Identifier: BSD-2-Clause
// What the texts for a person have in common.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

/// "granted" or "refused".
Cell verdict_cell(bool granted);

Style style_of_event(std::string_view kind);

/// "health       DEGRADED", then a line for each reason.
std::string health_lines(const control::Health& health, Color color);

/// "10.0.0.7 (02:00:5e:10:00:01)" of who has sent an unknown frame, as much of it as is known.
std::string print_sender(const control::Unknown& frame);

/// Rates and times as the messages of the protocol have them, with at most three decimals.
std::string bytes_per_second(std::uint64_t rate);
std::string bits_per_second(std::uint64_t rate);
/// "12.5 %" of `parts` of `whole`, which is more than 0.
std::string percent(std::uint64_t parts, std::uint64_t whole);

/// "7.543 Mbit/s" of the rate that the links of `use` carry one after the other.
std::string by_the_links(const control::MediumUse& use);

/// "laptop > relay > control"
std::string way(const std::vector<std::string>& places);

/// What a bus or a mesh gives a channel: "response 310 us, at most 5 ms guaranteed" or "path laptop
/// > relay > control, 7.543 Mbit/s by the links, 600 kB/s left in all links". Empty when it says
/// neither.
std::string describe(const control::MediumUse& use);

/// "2 of 3": the attribute set in use, the preferred one is 1; "none of 3" of a refusal; empty
/// where there is no choice.
std::string set_in_use(const control::Channel& channel);

}  // namespace mlcca::tools
