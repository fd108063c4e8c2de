// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/elsewhere.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include "base/text.hpp"
#include "daemon/cluster/codec.hpp"
#include "daemon/gateway/membership.hpp"

namespace mlcca::requests {
namespace {

namespace cc = core::cluster;

constexpr std::size_t kMostRead = 64;  // most entries of the store that are read for one answer
constexpr std::size_t kLongestShown = 63;

/// Whether this gateway knows the publisher: from the description, from an admission, or because it
/// carries the traffic for another gateway.
bool is_published_here(const core::State& state, const control::ChannelRequest& request,
                       std::size_t channel) {
  const auto& members = state.members();
  return std::ranges::any_of(members.publishers_of(channel), [&](std::size_t p) {
    return request.from.empty() || state.find_place(request.from) == members.publisher(p).place;
  });
}

/// Whether a reservation is for the traffic of an admission.
bool is_of_admission(const cc::Taken& taken) {
  return std::ranges::any_of(taken.part.rates,
                             [](const cc::RatePart& rate) { return rate.source.admission != 0; });
}

/// The request among `asked` that brought the publisher which `request` means; nullopt if there is
/// none.
std::optional<control::Admit> bringing(const cluster::Asked& asked,
                                       const control::ChannelRequest& request) {
  for (const auto* all : std::array{&asked.requests, &asked.also})
    for (const control::Request& one : *all) {
      const auto* const admit = std::get_if<control::Admit>(&one.body);
      if (admit != nullptr && !admit->from.empty() &&
          (request.from.empty() || admit->from == request.from))
        return *admit;
    }
  return std::nullopt;
}

std::string words(const core::State& state, const std::string& gateway,
                  const control::Admit& publisher, const control::ChannelRequest& request) {
  const std::string named =
      publisher.publisher.empty()
          ? std::string()
          : fmt::format(" ({})", printable(publisher.publisher, kLongestShown));
  const std::string from =
      request.from.empty() ? std::string() : fmt::format(" --from {}", request.from);
  const std::string to = request.to.empty() ? std::string() : fmt::format(" --to {}", request.to);
  const std::string from_where =
      state.find_place(publisher.from) ? publisher.from : std::string("elsewhere");
  return fmt::format(
      "the publisher of {} at {}{} was admitted by gateway {}, and nobody behind this gateway "
      "receives it yet: ask at {} for those who are to, with the options as here: 'mlccactl admit "
      "{}{}{}'",
      request.channel, from_where, named, gateway, gateway, request.channel, from, to);
}

}  // namespace

std::optional<std::string> admitted_elsewhere(const Context& context,
                                              const control::ChannelRequest& request,
                                              const Asked& asked) {
  const cc::Member* const member =
      context.membership == nullptr ? nullptr : context.membership->begun_member();
  const core::State& state = *context.scene.state;
  if (member == nullptr || describes_publisher(request) ||
      is_published_here(state, request, asked.channel))
    return std::nullopt;
  const cc::View& view = member->view();
  const std::string& name = state.system().channels[asked.channel].name;
  std::size_t read = 0;
  for (const auto& [key, record] : view.records().reservations) {
    if (key.gateway == member->self() || !record.taken || record.taken->channel != name ||
        !is_of_admission(*record.taken))
      continue;
    const cc::Alive alive = view.alive(key.gateway, context.membership->now());
    const auto there = view.records().asked.find({key.gateway, key.id});
    if (there == view.records().asked.end() || there->second.asked.stage != cc::Stage::granted ||
        (alive != cc::Alive::present && alive != cc::Alive::silent))
      continue;
    if (++read > kMostRead) break;
    const auto in_store = cluster::asked_in(there->second.asked.admission);
    if (!in_store) continue;
    if (const auto publisher = bringing(*in_store, request))
      return words(state, view.keys().gateway_name(key.gateway), *publisher, request);
  }
  return std::nullopt;
}

}  // namespace mlcca::requests
