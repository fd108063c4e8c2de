// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reloads.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response reload(Context& context, const Asker& asker, const control::ReloadRequest& /*request*/) {
  return context.reloads.begin(asker);
}

}  // namespace mlcca::requests
