// SPDX-License-Identifier: BSD-2-Clause
// What if: which deliveries would lose or gain if links or networks were different.
#include "daemon/gateway/outlook.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

/// Always made by a child process, because everything is decided once more.
Response what_if(Context& context, const Asker& asker, const control::WhatIfRequest& request) {
  return made_aside(context, asker, [&context, request]() -> Body {
    auto then = suppose(*context.scene.state, request);
    if (!then) return invalid(then.error().text);
    return outlook(*context.scene.state, **then);
  });
}

}  // namespace mlcca::requests
