// SPDX-License-Identifier: BSD-2-Clause
// Enforce, now or when nothing would have been dropped for some time, or audit.
#include <fmt/core.h>

#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kYear = 365ULL * 24 * 3600 * kSecond;

}  // namespace

Response mode(Context& context, const Asker& /*asker*/, const control::ModeRequest& request) {
  if (request.mode != "enforce" && request.mode != "audit")
    return invalid(fmt::format("there is no mode '{}': it is enforce or audit", request.mode));
  if (request.when_clean_ns == 0)
    return request.mode == "audit" ? context.modes.audit() : context.modes.enforce();
  if (request.mode == "audit")
    return invalid("audit mode begins at once: the time without drops is for enforce");
  if (request.when_clean_ns < kSecond || request.when_clean_ns > kYear)
    return invalid("the time without drops must be 1 second to 365 days");
  auto done = context.modes.enforce_when_clean(request.when_clean_ns);
  if (!done) return invalid(done.error().text);
  return std::move(*done);
}

}  // namespace mlcca::requests
