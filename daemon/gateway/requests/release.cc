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

namespace mlcca::requests {
namespace {

/// Whether another gateway has made this admission, and therefore ends it.
bool is_anothers(const Context& context, core::AdmissionId id) {
  return context.membership != nullptr && context.membership->is_adopted(id);
}

/// All admissions to a channel that this gateway can end, at least one. The error is for the
/// client.
Result<std::vector<core::AdmissionId>> admissions_of(const Context& context,
                                                     const std::string& channel) {
  const core::State& state = *context.scene.state;
  auto gone = context.admissions.left_out_of(channel);
  const auto named = channel_named(state, channel);
  if (!named && gone.empty()) return std::unexpected(named.error());
  for (const auto& [admission, of] : state.admissions())
    if (named && of == *named && !is_anothers(context, admission)) gone.push_back(admission);
  std::ranges::sort(gone);
  if (gone.empty())
    return fail(
        fmt::format("{0} has no run-time admission: what is described of it is stopped "
                    "by 'mlccactl withdraw {0}'",
                    state.system().channels[*named].name));
  return gone;
}

}  // namespace

Response release(Context& context, const Asker& /*asker*/, const control::ReleaseRequest& request) {
  std::vector<core::AdmissionId> gone;
  if (request.admission != 0 || !request.key.empty()) {
    if (context.membership != nullptr &&
        context.membership->refuse(request.key, "it was released while it waited"))
      return control::Done{
          fmt::format("the admission with the key '{}' does not wait any more", request.key)};
    const auto named = context.admissions.named(request.admission, request.key);
    if (!named) return invalid(named.error().text);
    gone.push_back(*named);
  } else {
    auto all = admissions_of(context, request.channel);
    if (!all) return invalid(all.error().text);
    gone = std::move(*all);
  }
  if (const auto done = context.admissions.release(gone, "released"); !done)
    return failed(done.error().text);
  return control::Done{
      fmt::format("released admission{} {}", gone.size() == 1 ? "" : "s", fmt::join(gone, ", "))};
}

}  // namespace mlcca::requests
