// SPDX-License-Identifier: BSD-2-Clause
// The server gives events to whoever has asked for them.
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response monitor(Context& /*context*/, const Asker& /*asker*/,
                 const control::MonitorRequest& /*request*/) {
  return control::Done{"events follow"};
}

}  // namespace mlcca::requests
