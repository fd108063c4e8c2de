// SPDX-License-Identifier: BSD-2-Clause
// Publishers that another gateway has admitted, and that this one does not carry.
#pragma once
#include <optional>
#include <string>

#include "control/messages.hpp"
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

/// Why nobody can be admitted here for the publisher that the request means: another gateway has
/// admitted it, as the store says, and it is not known here. With the command that does.
[[nodiscard]] std::optional<std::string> admitted_elsewhere(const Context& context,
                                                            const control::ChannelRequest& request,
                                                            const Asked& asked);

}  // namespace mlcca::requests
