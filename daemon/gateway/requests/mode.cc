// SPDX-License-Identifier: BSD-2-Clause
// Mode: enforce, now or when nothing would have been dropped for some time, or audit.
#include <fmt/core.h>

#include "daemon/gateway/audit_keeper.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kYear = 365ULL * 24 * 3600 * kSecond;

/// Writes the request to disk before the answer. After a crash, a former request would otherwise
/// decide the mode of the gates. If it cannot be written, the mode has changed, and it is an error
/// that this is forgotten.
Response written_down(const ModeParts& parts, control::Done done) {
  const std::uint64_t kept_before = parts.audit_keeper.kept_when_clean();
  const auto kept = parts.audit_keeper.keep(parts.history);
  if (kept || kept_before == parts.modes.when_clean()) return done;
  return failed(
      fmt::format("{}; but a daemon that crashes forgets it: {}", done.message, kept.error().text));
}

}  // namespace

Response mode(const ModeParts& parts, const Asker& /*asker*/, const control::ModeRequest& request) {
  if (request.mode != "enforce" && request.mode != "audit")
    return invalid(fmt::format("there is no mode '{}': it is enforce or audit", request.mode));
  if (request.when_clean_ns == 0)
    return written_down(parts,
                        request.mode == "audit" ? parts.modes.audit() : parts.modes.enforce());
  if (request.mode == "audit")
    return invalid("audit mode begins at once: the time without drops is for enforce");
  if (request.when_clean_ns < kSecond || request.when_clean_ns > kYear)
    return invalid("the time without drops must be 1 second to 365 days");
  auto done = parts.modes.enforce_when_clean(request.when_clean_ns);
  if (!done) return invalid(done.error().text);
  return written_down(parts, std::move(*done));
}

}  // namespace mlcca::requests
