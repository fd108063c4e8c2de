// SPDX-License-Identifier: BSD-2-Clause
// Publishers that another gateway has admitted and that this gateway does not carry.
#pragma once
#include <optional>
#include <string>

#include "control/messages.hpp"
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

/// Why no subscriber can be admitted here for the publisher that the request means: the store says
/// that another gateway has admitted this publisher, and this gateway does not know it. The text
/// has the command to use at that gateway. nullopt if that is not so.
[[nodiscard]] std::optional<std::string> admitted_elsewhere(const Context& context,
                                                            const control::ChannelRequest& request,
                                                            const Asked& asked);

}  // namespace mlcca::requests
