// SPDX-License-Identifier: BSD-2-Clause
// Monitor: the server passes events to clients that have made this request.
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response monitor(const NoParts& /*parts*/, const Asker& /*asker*/,
                 const control::MonitorRequest& /*request*/) {
  return control::Done{"events follow"};
}

}  // namespace mlcca::requests
