// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/bus_responses.hpp"

#include <algorithm>

namespace mlcca::core {
namespace {

/// The most messages that are each analysed as if they were added alone.
constexpr std::size_t kMostApart = 256;

/// The responses of the messages with these indices, in that order.
std::vector<can::Response> responses_of(const can::Assumptions& assumptions,
                                        std::span<const can::Message> messages,
                                        const std::vector<std::size_t>& which,
                                        std::span<const can::Time> at_least = {}) {
  std::vector<can::Message> chosen;
  chosen.reserve(which.size());
  for (const std::size_t i : which) {
    chosen.push_back(messages[i]);
    chosen.back().key = i;
  }
  return can::analyse_from(assumptions, chosen, at_least);
}

std::vector<can::Response> analysed_beside(const can::Assumptions& assumptions,
                                           std::span<const can::Message> messages,
                                           std::span<const Standing> standing) {
  std::vector<std::size_t> there;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < messages.size(); ++i)
    (standing[i].counted ? there : others).push_back(i);
  std::vector<can::Response> out(messages.size());
  const auto found = responses_of(assumptions, messages, there);
  std::vector<can::Time> at_least;
  for (std::size_t i = 0; i < there.size(); ++i) {
    out[there[i]] = found[i];
    at_least.push_back(found[i].bounded ? found[i].response : 0);
  }
  if (others.size() > kMostApart) {
    there.insert(there.end(), others.begin(), others.end());
    const auto all = responses_of(assumptions, messages, there);
    for (std::size_t i = at_least.size(); i < there.size(); ++i) out[there[i]] = all[i];
    return out;
  }
  at_least.push_back(0);
  for (const std::size_t other : others) {
    there.push_back(other);
    out[other] = responses_of(assumptions, messages, there, at_least).back();
    there.pop_back();
  }
  return out;
}

/// The responses of the messages that count, with the longest jitters that they can have.
std::vector<can::Response> analysed_late(const can::Assumptions& assumptions,
                                         std::span<const can::Message> messages,
                                         std::span<const Standing> standing) {
  std::vector<can::Message> late(messages.begin(), messages.end());
  std::vector<std::size_t> there;
  for (std::size_t i = 0; i < late.size(); ++i) {
    late[i].jitter = std::max(late[i].jitter, standing[i].most_jitter);
    if (standing[i].counted) there.push_back(i);
  }
  const auto found = responses_of(assumptions, late, there);
  std::vector<can::Response> out(messages.size());
  for (std::size_t i = 0; i < there.size(); ++i) out[there[i]] = found[i];
  return out;
}

/// The bound that admission guarantees, if the analysis has no smaller one.
BusResponse bound_of(const can::Assumptions& assumptions, const can::Message& message,
                     const can::Response& analysed, bool all_known) {
  if (all_known && can::fits(assumptions, message, analysed)) return {analysed, false};
  BusResponse out{analysed, true};
  if (!all_known || !analysed.meets(message.deadline)) out.response.response = message.deadline;
  out.response.bounded = true;
  if (message.queue < assumptions.queues.size()) {
    const std::uint32_t length = assumptions.queues[message.queue].length;
    out.response.queued_frames = all_known ? std::min(analysed.queued_frames, length) : length;
  }
  return out;
}

}  // namespace

std::vector<BusResponse> responses_beside(const can::Assumptions& assumptions,
                                          std::span<const can::Message> messages,
                                          std::span<const Standing> standing, Known known) {
  const auto analysed = analysed_beside(assumptions, messages, standing);
  const bool is_delayed =
      known == Known::forms && std::ranges::any_of(standing, &Standing::admitted);
  std::vector<can::Response> latest;
  if (is_delayed) latest = analysed_late(assumptions, messages, standing);
  std::vector<BusResponse> out(messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (!standing[i].admitted)
      out[i] = {analysed[i], false};
    else if (is_delayed && standing[i].most_jitter == 0)
      out[i] = bound_of(assumptions, messages[i], latest[i], true);
    else
      out[i] = bound_of(assumptions, messages[i], analysed[i], known == Known::all);
  }
  return out;
}

Known known_of(const InspectedBuses& buses, std::size_t network) {
  if (buses.all_known[network]) return Known::all;
  return buses.forms_known[network] ? Known::forms : Known::little;
}

Standing standing_of(const InspectedBuses& buses, const BusMessage& message) {
  return {.counted = message.is_counted(),
          .admitted = buses.guarded[message.network] && message.is_counted(),
          .most_jitter = message.unknown.empty() ? 0 : std::max<can::Time>(message.most_jitter, 1)};
}

std::vector<SentMessage> sent_beside(const InspectedBuses& buses, std::size_t network) {
  const auto& assumptions = buses.assumptions[network];
  if (!assumptions) return {};
  std::vector<SentMessage> out;
  std::vector<can::Message> messages;
  std::vector<Standing> standing;
  for (const BusMessage& m : buses.messages) {
    if (m.network != network || !m.sent) continue;
    out.push_back({.message = &m, .response = {}, .by_admission = false});
    messages.push_back(*m.sent);
    standing.push_back(standing_of(buses, m));
  }
  const auto found = responses_beside(*assumptions, messages, standing, known_of(buses, network));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].response = found[i].response;
    out[i].by_admission = found[i].by_admission;
  }
  return out;
}

BusLoad load_of(const can::Assumptions& assumptions, std::span<const BusLoadPart> messages) {
  std::vector<can::Message> present;
  std::vector<can::Message> all;
  for (const BusLoadPart& part : messages) {
    if (part.present) present.push_back(part.message);
    all.push_back(part.message);
  }
  BusLoad load;
  load.present = load.at_most = can::utilisation_ppm(assumptions, present);
  if (present.size() == all.size()) return load;
  constexpr std::uint64_t all_the_time = 1'000'000;
  load.at_most =
      std::max(load.present, std::min(all_the_time, can::utilisation_ppm(assumptions, all)));
  return load;
}

std::optional<BusLoad> load_on(const InspectedBuses& buses, std::size_t network) {
  if (network >= buses.assumptions.size() || !buses.assumptions[network]) return std::nullopt;
  std::vector<BusLoadPart> parts;
  for (const BusMessage& m : buses.messages)
    if (m.network == network && m.sent && m.is_counted()) parts.push_back({*m.sent, m.present});
  return load_of(*buses.assumptions[network], parts);
}

}  // namespace mlcca::core
