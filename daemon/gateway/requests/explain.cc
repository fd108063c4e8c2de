// SPDX-License-Identifier: BSD-2-Clause
#include <utility>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca::requests {

Response explain(const ChannelsParts& parts, const Asker& asker,
                 const control::ExplainRequest& request) {
  auto left_out = parts.admissions.left_out_report(request.channel);
  const auto channel = channel_named(*parts.scene.state, request.channel);
  if (!channel && left_out.empty()) return invalid(channel.error().text);
  const auto report = [parts, channel, left_out = std::move(left_out)] {
    control::Channels out;
    if (channel) out = parts.channels.known({*channel, {}, {}, {}});
    out.admissions_left_out = left_out;
    return out;
  };
  return parts.replies.made(asker, channel && parts.estimates.has_many_lines(*channel), report);
}

}  // namespace mlcca::requests
