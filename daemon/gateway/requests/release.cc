// SPDX-License-Identifier: BSD-2-Clause
// Release: ends admissions that were made at run time.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca::requests {
namespace {

/// Whether another gateway has made this admission, and therefore ends it.
bool is_anothers(const ReleaseParts& parts, core::AdmissionId id) {
  return parts.membership != nullptr && parts.membership->is_adopted(id);
}

/// All admissions to a channel that this gateway can end, at least one. The error is for the
/// client.
Result<std::vector<core::AdmissionId>> admissions_of(const ReleaseParts& parts,
                                                     const std::string& channel) {
  const core::State& state = *parts.scene.state;
  auto gone = parts.admissions.left_out_of(channel);
  const auto named = channel_named(state, channel);
  if (!named && gone.empty()) return std::unexpected(named.error());
  for (const auto& [admission, of] : state.admissions())
    if (named && of == *named && !is_anothers(parts, admission)) gone.push_back(admission);
  std::ranges::sort(gone);
  if (gone.empty())
    return fail(
        fmt::format("{0} has no run-time admission: what is described of it is stopped "
                    "by 'mlccactl withdraw {0}'",
                    state.system().channels[*named].name));
  return gone;
}

}  // namespace

Response release(const ReleaseParts& parts, const Asker& /*asker*/,
                 const control::ReleaseRequest& request) {
  std::vector<core::AdmissionId> gone;
  if (request.admission != 0 || !request.key.empty()) {
    if (parts.membership != nullptr &&
        parts.membership->refuse(request.key, "it was released while it waited"))
      return control::Done{
          fmt::format("the admission with the key '{}' does not wait any more", request.key)};
    const auto named = parts.admissions.named(request.admission, request.key);
    if (!named) return invalid(named.error().text);
    gone.push_back(*named);
  } else {
    auto all = admissions_of(parts, request.channel);
    if (!all) return invalid(all.error().text);
    gone = std::move(*all);
  }
  if (const auto done = parts.admissions.release(gone, "released"); !done)
    return failed(done.error().text);
  return control::Done{
      fmt::format("released admission{} {}", gone.size() == 1 ? "" : "s", fmt::join(gone, ", "))};
}

}  // namespace mlcca::requests
