// SPDX-License-Identifier: BSD-2-Clause
// Enforce, or audit: count what would be dropped and drop nothing.
#include <fmt/core.h>

#include "daemon/gateway/drop_reports.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca::requests {

Response mode(Context& context, const Asker& /*asker*/, const control::ModeRequest& request) {
  if (request.mode != "enforce" && request.mode != "audit")
    return invalid(fmt::format("there is no mode '{}': it is enforce or audit", request.mode));
  {
    // What was dropped so far is reported as what became of it, and no client has asked for it.
    const EventLog::Acting no_actor(context.log, std::nullopt);
    context.drops.report_all();
  }
  if (request.mode == "audit") {
    context.control.set_mode(enforce::Mode::audit);
    const std::string line = "AUDIT MODE: nothing is dropped, everything is only counted";
    context.log.warning(Kind::mode, line);
    return control::Done{line};
  }
  context.control.set_mode(enforce::Mode::enforce);
  const std::string line = "enforcing: what is not admitted is dropped";
  context.log.notice(Kind::mode, line);
  return control::Done{line};
}

}  // namespace mlcca::requests
