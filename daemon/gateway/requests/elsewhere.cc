// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/elsewhere.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/recorder.hpp"

namespace mlcca::requests {
namespace {

namespace cc = core::cluster;

constexpr std::size_t kMostRead = 64;  // most entries of the store that are read for one answer

/// Whether this gateway has the publisher: from the description, or from an admission of its own.
/// One that it only carries for another gateway ends with the admission of that gateway.
bool is_published_here(const Scene& scene, const Recorder& recorder,
                       const control::ChannelRequest& request, std::size_t channel) {
  const core::State& state = *scene.state;
  const auto& members = state.members();
  return std::ranges::any_of(members.publishers_of(channel), [&](std::size_t p) {
    const core::AdmissionId id = members.admission_of_publisher(p);
    const bool own = id == 0 || recorder.contents().admissions.find(id) != nullptr;
    return own &&
           (request.from.empty() || state.find_place(request.from) == members.publisher(p).place);
  });
}

/// Whether a reservation is for the traffic of an admission.
bool is_of_admission(const cc::Taken& taken) {
  return std::ranges::any_of(taken.part.rates,
                             [](const cc::RatePart& rate) { return rate.source.admission != 0; });
}

/// Whether one of the requests in `asked` brought the publisher which `request` means.
bool brings(const cluster::StoredRequest& asked, const control::ChannelRequest& request) {
  const auto does = [&](const control::Request& one) {
    const auto* const admit = std::get_if<control::Admit>(&one.body);
    return admit != nullptr && !admit->from.empty() &&
           (request.from.empty() || admit->from == request.from);
  };
  return std::ranges::any_of(std::array{&asked.requests, &asked.also},
                             [&](const auto* all) { return std::ranges::any_of(*all, does); });
}

/// The gateway with the only port at that place; nullopt if there are several or none.
std::optional<std::size_t> only_gateway_at(const core::System& system, core::Place place) {
  if (place.kind == core::Place::Kind::gateway) return place.index;
  std::optional<std::size_t> only;
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    if (system.gateways[g].port_on(place.index) == nullptr) continue;
    if (only) return std::nullopt;
    only = g;
  }
  return only;
}

/// The first gateway that has reserved for such a publisher, by the store.
std::optional<std::size_t> gateway_in_store(const Membership& membership, const cc::Member& member,
                                            const control::ChannelRequest& request,
                                            const std::string& channel) {
  const cc::View& view = member.view();
  std::size_t read = 0;
  for (const auto& [key, record] : view.records().reservations) {
    if (key.gateway == member.self() || !record.taken || record.taken->channel != channel ||
        !is_of_admission(*record.taken))
      continue;
    const cc::Alive alive = view.alive(key.gateway, membership.now());
    const auto there = view.records().asked.find({key.gateway, key.id});
    if (there == view.records().asked.end() || there->second.asked.stage != cc::Stage::granted ||
        (alive != cc::Alive::present && alive != cc::Alive::standby && alive != cc::Alive::silent))
      continue;
    if (++read > kMostRead) break;
    const auto in_store = cluster::asked_in(there->second.asked.admission);
    if (in_store && brings(*in_store, request)) return key.gateway;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::size_t> gateway_to_ask(const Scene& scene, const Recorder& recorder,
                                          const Membership* membership,
                                          const control::ChannelRequest& request,
                                          const ParsedRequest& asked) {
  const cc::Member* const member = membership == nullptr ? nullptr : membership->begun_member();
  const core::State& state = *scene.state;
  if (member == nullptr || !asked.admission || !asked.admission->subscriber ||
      describes_publisher(request) || is_published_here(scene, recorder, request, asked.channel))
    return std::nullopt;
  const auto from = state.find_place(request.from);
  if (const auto only = from ? only_gateway_at(state.system(), *from) : std::nullopt)
    return *only == member->self() ? std::nullopt : only;
  return gateway_in_store(*membership, *member, request,
                          state.system().channels[asked.channel].name);
}

std::optional<std::string> decided_elsewhere(const Scene& scene, const Recorder& recorder,
                                             const Membership* membership,
                                             const control::ChannelRequest& request,
                                             const ParsedRequest& asked) {
  const auto gateway = gateway_to_ask(scene, recorder, membership, request, asked);
  if (!gateway) return std::nullopt;
  const std::string& name = scene.state->system().gateways[*gateway].name;
  const std::string from =
      request.from.empty() ? std::string() : fmt::format(" --from {}", request.from);
  return fmt::format(
      "the publisher of {} is admitted by gateway {}, which decides with this one: ask at {} what "
      "would be granted, with the options as here: 'mlccactl query {}{} --to {}'",
      request.channel, name, name, request.channel, from, request.to);
}

control::Admit subscriber_alone(control::Admit request, core::AdmissionId id) {
  request.from.clear();
  // With a name it is a new subscriber, even where the other gateway's admission has put one.
  if (request.subscriber.empty()) request.subscriber = fmt::format("subscriber-{}", id);
  return request;
}

control::Admit what_others_need(const control::Request& request) {
  const auto& admit = std::get<control::Admit>(request.body);
  control::Admit asked = subscriber_alone(admit, request.id);
  asked.from = admit.from;
  asked.key.clear();
  asked.lease_ns = 0;
  asked.hold = false;
  return asked;
}

Reserving::Wish wish_elsewhere(const std::string& channel, const control::Request& request,
                               std::size_t gateway) {
  return {.footprint = {.parts = {}, .gateways = {gateway}},
          .publisher = {},
          .asked = {.channel = channel,
                    .requests = {{.id = request.id, .body = what_others_need(request)}},
                    .also = {},
                    .on_behalf = true}};
}

}  // namespace mlcca::requests
