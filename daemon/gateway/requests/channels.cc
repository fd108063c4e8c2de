// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kLeastRow = 32;  // least bytes on the wire

}  // namespace

Response channels(const ChannelsParts& parts, const Asker& asker,
                  const control::ChannelsRequest& /*request*/) {
  const std::size_t all = parts.scene.state->decisions().size();
  if (parts.estimates.has_channel_of_many_ends())
    return parts.replies.aside(asker, [parts, all] {
      control::Channels out;
      for (std::size_t c = 0; c < all; ++c)
        std::ranges::move(parts.channels.known({c, {}, {}, {}}).channels,
                          std::back_inserter(out.channels));
      out.admissions_left_out = parts.admissions.left_out_report();
      return out;
    });
  return parts.replies.in_slices(all * kLeastRow,
                                 [parts, at = ChannelReports::Position{}, first = true]() mutable {
                                   serve::Slice slice = parts.channels.some(at);
                                   if (std::exchange(first, false))
                                     std::get<control::Channels>(slice.body).admissions_left_out =
                                         parts.admissions.left_out_report();
                                   return slice;
                                 });
}

}  // namespace mlcca::requests
