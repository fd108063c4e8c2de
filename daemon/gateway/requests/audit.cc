// SPDX-License-Identifier: BSD-2-Clause
// Audit: what the gates refuse, of which senders, since when.
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

control::Audit audit_of(const Context& c) {
  control::Audit out = c.audit.report();
  out.mode = c.modes.name();
  out.when_clean_ns = c.modes.when_clean();
  out.clean_ns = c.modes.clean();
  return out;
}

}  // namespace

Response audit(Context& context, const Asker& asker, const control::AuditRequest& /*request*/) {
  if (context.delivery_health.is_large())
    return made_aside(context, asker, [&context] { return audit_of(context); });
  return audit_of(context);
}

}  // namespace mlcca::requests
