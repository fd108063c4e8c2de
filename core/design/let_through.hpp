// SPDX-License-Identifier: BSD-2-Clause
// What can really be on a bus: what is granted, at best perhaps, and what a refused publisher of
// that bus sends all the same, since no gate lies in between. A gate drops whatever else is
// refused before it reaches the bus.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can/analysis.hpp"
#include "core/can/message.hpp"
#include "core/design/inspect.hpp"

namespace mlcca::core {

/// Responses beside what is let through: of that all together, of each other message as if it came
/// to the bus beside it. Of very many other messages at most that: as if all of them did.
[[nodiscard]] std::vector<can::Response> responses_beside(const can::Assumptions& assumptions,
                                                          std::span<const can::Message> messages,
                                                          const std::vector<bool>& let_through);

/// The messages of a network of which the description says enough, as they are on the bus or would
/// be beside what is let through there. None where it is not analysed.
[[nodiscard]] std::vector<SentMessage> sent_beside(const InspectedBuses& buses,
                                                   std::size_t network);

/// The time of the bus that what is let through takes, 1e-6; nothing where it is not analysed.
[[nodiscard]] std::optional<std::uint64_t> let_through_ppm(const InspectedBuses& buses,
                                                           std::size_t network);

}  // namespace mlcca::core
