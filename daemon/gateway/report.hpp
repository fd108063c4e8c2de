// SPDX-License-Identifier: BSD-2-Clause
// Decisions and the state of the gates in the words of the control protocol.
#pragma once
#include <cstdint>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/outside/frames.hpp"

namespace mlcca {

/// Why it was decided so, with what is wrong with a network that cannot be used.
[[nodiscard]] std::string why(const core::State& state, const core::Verdict& verdict);
/// Whether what the publisher of a delivery holds of a mesh is available to whoever asks.
enum class Own : std::uint8_t { is_available, is_taken };
/// What a medium gives a delivery, as its links and what is reserved are now.
[[nodiscard]] control::MediumUse medium_report(const core::State& state,
                                               const core::Verdict& verdict,
                                               const core::MediumUse& use, Own own);
[[nodiscard]] control::Channel channel_report(const core::State& state,
                                              const core::Verdict& verdict, const Frames& frames);
/// No reaction time is promised where nothing reports the silence of the publisher. `why` may be
/// empty: it is reported.
void set_not_supervised(control::Channel& channel, std::string why);

[[nodiscard]] control::Network network_report(const core::State& state, std::size_t index);

/// "emergency-switch (0xa4efeccc3210b497) refused from second-can to robot-can: Omission …".
/// "video (0x…) switched from set 1 to set 2 of 2, from laptop to awds: …"
[[nodiscard]] std::string switch_line(const core::State& state, const core::Verdict& verdict,
                                      std::size_t former_set);
/// "video (0x…) takes another way from laptop to field: lan, back-up, field instead of lan, main,
/// field: …"
[[nodiscard]] std::string reroute_line(const core::State& state, const core::Verdict& verdict,
                                       const core::Route& former_route);
[[nodiscard]] std::string verdict_line(const core::State& state, const core::Verdict& verdict);

}  // namespace mlcca
