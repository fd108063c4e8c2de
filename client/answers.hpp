// SPDX-License-Identifier: BSD-2-Clause
// From messages of the daemon to what a program is given.
#pragma once
#include "control/messages.hpp"
#include "mlcca/client/client.hpp"

namespace mlcca::client {

/// Of a reply to AnnounceRequest.
[[nodiscard]] Answer answer_of(const control::Reply& reply);
/// Of an event, with the answers before and after it, which say whether a set is a better one.
[[nodiscard]] Exception exception_of(const control::Event& event, const Answer& before,
                                     const Answer& after);
/// The same deliveries are granted, by the same attribute sets.
[[nodiscard]] bool same_verdicts(const Answer& a, const Answer& b);
/// Whether the verdicts may be others than before.
[[nodiscard]] bool changes_verdicts(const control::Event& event);

}  // namespace mlcca::client
