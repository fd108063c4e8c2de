// SPDX-License-Identifier: BSD-2-Clause
#include <utility>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response explain(Context& context, const Asker& asker, const control::ExplainRequest& request) {
  auto left_out = context.admissions.left_out_report(request.channel);
  const auto channel = channel_named(*context.scene.state, request.channel);
  if (!channel && left_out.empty()) return invalid(channel.error().text);
  const auto report = [&context, channel, left_out = std::move(left_out)] {
    control::Channels out;
    if (channel) out = context.channels.known({*channel, {}, {}, {}});
    out.admissions_left_out = left_out;
    return out;
  };
  if (!channel || !context.channels.has_many_lines(*channel)) return report();
  return made_aside(context, asker, report);
}

}  // namespace mlcca::requests
