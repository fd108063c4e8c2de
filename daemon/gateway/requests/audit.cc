// SPDX-License-Identifier: BSD-2-Clause
// Audit: what the gates refuse, of which senders, since when.
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

control::Audit audit_of(const AuditParts& c) {
  control::Audit out = c.audit.report();
  out.mode = c.modes.name();
  out.when_clean_ns = c.modes.when_clean();
  out.clean_ns = c.modes.clean();
  return out;
}

}  // namespace

Response audit(const AuditParts& parts, const Asker& asker,
               const control::AuditRequest& /*request*/) {
  return parts.replies.made(asker, parts.delivery_health.is_large(),
                            [parts] { return audit_of(parts); });
}

}  // namespace mlcca::requests
