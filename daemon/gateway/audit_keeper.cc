// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/audit_keeper.hpp"

#include <algorithm>
#include <string>
#include <variant>

#include "control/buffer.hpp"
#include "control/codec.hpp"

namespace mlcca {
namespace {

constexpr const char* kName = "audit";

}  // namespace

/// If the history cannot be read, the history itself reports it. Anything else than a reply to an
/// audit request, for example of a later version, is ignored.
void AuditKeeper::restore(store::History& from) {
  kept_at_ = clock_.monotonic_s();
  const auto kept = patience_.wait_for([&from] { return from.note(kName); });
  if (!kept || kept->empty()) return;
  control::Buffer buffer;
  buffer.append(*kept);
  const auto reply = control::decode_reply(buffer);
  const auto* const audit =
      reply && *reply ? std::get_if<control::Audit>(&(*reply)->body) : nullptr;
  if (audit == nullptr) {
    log_.warning(Kind::problem,
                 "what audit mode has found so far is lost: it cannot be read by this version");
    return;
  }
  audit_.restore(*audit);
  modes_.restore(audit->when_clean_ns);
  kept_when_clean_ = audit->when_clean_ns;
}

void AuditKeeper::poll(store::History& to) {
  const std::int64_t interval = std::max(kInterval, kept_bytes_ / kBytesPerSecond);
  const bool is_due = clock_.monotonic_s() - kept_at_ >= interval;
  // The time until enforcing has ended, or was requested.
  const bool is_changed = modes_.when_clean() != kept_when_clean_ && !is_behind_;
  if (is_due || is_changed) static_cast<void>(keep(to));
}

Result<void> AuditKeeper::keep(store::History& to) {
  kept_at_ = clock_.monotonic_s();
  const std::uint64_t when_clean = modes_.when_clean();
  if (!audit_.take_news() && when_clean == kept_when_clean_ && !is_behind_) return {};
  control::Audit audit = audit_.contents();
  audit.when_clean_ns = when_clean;
  const std::string bytes = control::encode(control::Reply{0, std::move(audit)});
  const auto kept = patience_.wait_for([&] { return to.keep_note(kName, bytes); });
  if (problem_.is_new(kept ? "" : "what audit mode has found is not kept: " + kept.error().text))
    log_.warning(Kind::problem, problem_.text());
  is_behind_ = !kept;
  if (!kept) return std::unexpected(kept.error());
  kept_when_clean_ = when_clean;
  kept_bytes_ = static_cast<std::int64_t>(bytes.size());
  return {};
}

}  // namespace mlcca
