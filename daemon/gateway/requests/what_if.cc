// SPDX-License-Identifier: BSD-2-Clause
// What if: which deliveries would lose or gain if links or networks were different.
#include "daemon/gateway/outlook.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

/// Always made by a child process, because everything is decided once more.
Response what_if(const WhatIfParts& parts, const Asker& asker,
                 const control::WhatIfRequest& request) {
  return parts.replies.aside(asker, [parts, request]() -> Body {
    auto then = suppose(*parts.scene.state, request);
    if (!then) return invalid(then.error().text);
    return outlook(*parts.scene.state, **then);
  });
}

}  // namespace mlcca::requests
