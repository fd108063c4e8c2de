// SPDX-License-Identifier: BSD-2-Clause
// Who would lose and who would gain, if links or networks were others?
#include "daemon/gateway/outlook.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

/// Always aside: all that is known is decided once more.
Response what_if(Context& context, const Asker& asker, const control::WhatIfRequest& request) {
  return made_aside(context, asker, [&context, request]() -> Body {
    auto then = suppose(*context.scene.state, request);
    if (!then) return invalid(then.error().text);
    return outlook(*context.scene.state, **then);
  });
}

}  // namespace mlcca::requests
