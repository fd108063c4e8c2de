// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kLeastRow = 32;  // least bytes on the wire

}  // namespace

Response channels(Context& context, const Asker& asker,
                  const control::ChannelsRequest& /*request*/) {
  const std::size_t all = context.scene.state->decisions().size();
  if (context.channels.has_channel_of_many_ends())
    return made_aside(context, asker, [&context, all] {
      control::Channels out;
      for (std::size_t c = 0; c < all; ++c)
        std::ranges::move(context.channels.known({c, {}, {}, {}}).channels,
                          std::back_inserter(out.channels));
      out.admissions_left_out = context.admissions.left_out_report();
      return out;
    });
  return made_in_slices(context, all * kLeastRow,
                        [&context, at = ChannelReports::Position{}, first = true]() mutable {
                          serve::Slice slice = context.channels.some(at);
                          if (std::exchange(first, false))
                            std::get<control::Channels>(slice.body).admissions_left_out =
                                context.admissions.left_out_report();
                          return slice;
                        });
}

}  // namespace mlcca::requests
