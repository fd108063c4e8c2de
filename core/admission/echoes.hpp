// SPDX-License-Identifier: BSD-2-Clause
// Events of a channel that a gateway would carry on although it was not admitted for them, because
// they look like those of another publisher: around a ring of gateways they would go on for ever.
#pragma once
#include <cstddef>
#include <optional>
#include <span>

#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Events that a gateway sends on a network whose frames carry the subject come from its address.
/// Who takes events there without regard to their address takes these, too.
[[nodiscard]] bool takes_any_sender(const System& system, const Publisher& publisher,
                                    const Route& route, std::size_t gateway);

/// A gateway that would carry events of one publisher on as those of another one, by what is
/// granted of the verdicts; nothing: none would. All verdicts are of one channel.
[[nodiscard]] std::optional<std::size_t> find_echo(const System& system, const Members& members,
                                                   std::span<const Verdict> verdicts);

}  // namespace mlcca::core
