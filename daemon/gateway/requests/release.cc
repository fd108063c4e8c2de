// SPDX-License-Identifier: BSD-2-Clause
// Admissions that were made at run time end.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

/// Another gateway has admitted it, and ends it.
bool is_anothers(const Context& context, core::AdmissionId id) {
  return context.membership != nullptr && context.membership->is_adopted(id);
}

}  // namespace

Response release(Context& context, const Asker& /*asker*/, const control::ReleaseRequest& request) {
  const core::State& state = *context.scene.state;
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
    gone = context.admissions.left_out_of(request.channel);
    const auto named = channel_named(state, request.channel);
    if (!named && gone.empty()) return invalid(named.error().text);
    for (const auto& [admission, of] : state.admissions())
      if (named && of == *named && !is_anothers(context, admission)) gone.push_back(admission);
    std::ranges::sort(gone);
    if (gone.empty())
      return invalid(
          fmt::format("{0} has no run-time admission: what is described of it is stopped "
                      "by 'mlccactl withdraw {0}'",
                      state.system().channels[*named].name));
  }
  if (const auto done = context.admissions.release(gone, "released"); !done)
    return failed(done.error().text);
  return control::Done{
      fmt::format("released admission{} {}", gone.size() == 1 ? "" : "s", fmt::join(gone, ", "))};
}

}  // namespace mlcca::requests
