// SPDX-License-Identifier: BSD-2-Clause
// From messages of the daemon to what a program is given.
#pragma once
#include <optional>

#include "control/messages.hpp"
#include "mlcca/client/client.hpp"

namespace mlcca::client {

/// Of a reply to AnnounceRequest. Nothing: the daemon could not answer, and may later.
[[nodiscard]] std::optional<Answer> answer_of(const control::Reply& reply);
/// Of a subscription that the gateway has passed on, refused or granted: what it decides itself has
/// not changed. Nothing: the event is of something else.
[[nodiscard]] std::optional<Cause> said_further_on(const control::Event& event);
/// State and reason of an answer follow from its deliveries.
void summarise(Answer& answer);

enum class Meaning : std::uint8_t {
  happened,   ///< an exception by itself
  verdict,    ///< what is decided may be otherwise: ask
  withdrawn,  ///< the same, and the safe side is known at once
};
[[nodiscard]] Meaning meaning_of(const control::Event& event);
/// Of what happened.
[[nodiscard]] Cause cause_of(const control::Event& event);

}  // namespace mlcca::client
