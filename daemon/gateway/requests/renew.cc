// SPDX-License-Identifier: BSD-2-Clause
// Renew: the lease of an admission starts again.
#include <fmt/core.h>

#include "core/model/text.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response renew(const RenewParts& parts, const Asker& /*asker*/,
               const control::RenewRequest& request) {
  Admissions& admissions = parts.admissions;
  const auto named = admissions.named(request.admission, request.key);
  if (!named) return invalid(named.error().text);
  const core::AdmissionId id = *named;
  if (const auto out = admissions.left_out().find(id);
      out != admissions.left_out().end() && !admissions.waits(id))
    return invalid(words_of(out->second));
  if (!admissions.remaining(id))
    return control::Done{
        fmt::format("admission {} {}", id,
                    admissions.is_held(id) ? "is held by a connection" : "has no lease")};
  admissions.renew(id);
  return control::Done{
      fmt::format("renewed: admission {} has {} left", id,
                  core::format_value(Attribute::latency, *admissions.remaining(id)))};
}

}  // namespace mlcca::requests
