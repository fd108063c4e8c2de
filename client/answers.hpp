// SPDX-License-Identifier: BSD-2-Clause
// Translates messages of the daemon into the answers and exceptions that a program receives.
#pragma once
#include <optional>

#include "control/messages.hpp"
#include "mlcca/client/client.hpp"

namespace mlcca::client {

/// The answer that a reply to an AnnounceRequest states. Nullopt if the daemon could not answer now
/// but may later (an error of kind `world`), or if the reply is of another kind.
[[nodiscard]] std::optional<Answer> answer_of(const control::Reply& reply);
/// The decision of a gateway further on about a subscription that this gateway has passed on:
/// granted or refused. The decision of this gateway has not changed then. Nullopt for every other
/// event.
[[nodiscard]] std::optional<Cause> said_further_on(const control::Event& event);
/// Sets state and reason of an answer according to its deliveries.
void summarise(Answer& answer);

/// What an event of the daemon means for the answer that a channel has.
enum class Meaning : std::uint8_t {
  happened,   ///< an exception of its own; the decision is the same
  verdict,    ///< the decision may have changed: ask the daemon
  withdrawn,  ///< as `verdict`, but the delivery counts as refused at once, which is the safe side
};
[[nodiscard]] Meaning meaning_of(const control::Event& event);
/// The cause of an event whose meaning is `happened`.
[[nodiscard]] Cause cause_of(const control::Event& event);

}  // namespace mlcca::client
