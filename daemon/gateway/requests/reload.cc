// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reloads.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response reload(const ReloadParts& parts, const Asker& asker,
                const control::ReloadRequest& /*request*/) {
  return parts.reloads.begin(asker);
}

}  // namespace mlcca::requests
