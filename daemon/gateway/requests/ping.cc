// SPDX-License-Identifier: BSD-2-Clause
// Ping: a client asks whether the daemon answers.
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response ping(const NoParts& /*parts*/, const Asker& /*asker*/,
              const control::PingRequest& /*request*/) {
  return control::Done{};
}

}  // namespace mlcca::requests
