// SPDX-License-Identifier: BSD-2-Clause
// Detects events that a gateway would forward although they were not admitted there, because they
// are indistinguishable from those of another publisher. In a ring of gateways they would circulate
// for ever.
#pragma once
#include <cstddef>
#include <optional>
#include <span>

#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Whether a gateway on the route takes the publisher's events from any sender (by a wildcard
/// entry). It then also takes the events that another gateway sends there under its own address.
[[nodiscard]] bool takes_any_sender(const System& system, const Publisher& publisher,
                                    const Route& route, std::size_t gateway);

/// Finds a gateway that would forward events of one publisher as those of another, given the
/// granted verdicts; nullopt if there is none. All verdicts are of one channel.
[[nodiscard]] std::optional<std::size_t> find_echo(const System& system, const Members& members,
                                                   std::span<const Verdict> verdicts);

}  // namespace mlcca::core
