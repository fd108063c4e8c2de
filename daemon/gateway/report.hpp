// SPDX-License-Identifier: BSD-2-Clause
// Turns decisions and the state of gates into messages of the control protocol.
#pragma once
#include <cstdint>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/outside/frames.hpp"

namespace mlcca {

/// The reason of a verdict, with what is wrong with a network that cannot be used.
[[nodiscard]] std::string why(const core::State& state, const core::Verdict& verdict);
/// Whether the medium time that the publisher of a delivery already holds counts as available to
/// the asker.
enum class Own : std::uint8_t { is_available, is_taken };
/// What a medium gives a delivery with its present links and reservations.
[[nodiscard]] control::MediumUse medium_report(const core::State& state,
                                               const core::Verdict& verdict,
                                               const core::MediumUse& use, Own own);
/// What the description says of a channel itself.
[[nodiscard]] control::Channel described_row(const core::EventChannel& channel);
/// Which delivery a verdict is about: names and places, without the verdict itself.
[[nodiscard]] control::Channel delivery_report(const core::State& state,
                                               const core::Verdict& verdict);
[[nodiscard]] control::Channel channel_report(const core::State& state,
                                              const core::Verdict& verdict, const Frames& frames);
/// Notes why nothing reports the silence of the publisher, so that no reaction time is promised. An
/// empty `why` means that its silence is reported.
void set_not_supervised(control::Channel& channel, std::string why);

[[nodiscard]] control::Network network_report(const core::State& state, std::size_t index);

/// A line such as "video (0x…) degraded from attribute set 1 to 2 of 2, from laptop to awds: …".
[[nodiscard]] std::string switch_line(const core::State& state, const core::Verdict& verdict,
                                      std::size_t former_set);
/// A line such as "video (0x…) takes another route from laptop to field: lan, back-up, field
/// instead of lan, main, field: …".
[[nodiscard]] std::string reroute_line(const core::State& state, const core::Verdict& verdict,
                                       const core::Route& former_route);
/// A line such as "emergency-switch (0xa4efeccc3210b497) refused from second-can to robot-can:
/// Omission …".
[[nodiscard]] std::string verdict_line(const core::State& state, const core::Verdict& verdict);

}  // namespace mlcca
