// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/let_through.hpp"

#include <algorithm>

namespace mlcca::core {
namespace {

/// Of so many messages each is analysed as if it came alone.
constexpr std::size_t kMostApart = 256;

/// Responses of the messages of that number, in their order.
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

}  // namespace

std::vector<can::Response> responses_beside(const can::Assumptions& assumptions,
                                            std::span<const can::Message> messages,
                                            const std::vector<bool>& let_through) {
  std::vector<std::size_t> there;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < messages.size(); ++i) (let_through[i] ? there : others).push_back(i);
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

std::vector<SentMessage> sent_beside(const InspectedBuses& buses, std::size_t network) {
  const auto& assumptions = buses.assumptions[network];
  if (!assumptions) return {};
  std::vector<SentMessage> out;
  std::vector<can::Message> messages;
  std::vector<bool> let_through;
  for (const BusMessage& m : buses.messages) {
    if (m.network != network || !m.sent) continue;
    out.push_back({&m, {}});
    messages.push_back(*m.sent);
    let_through.push_back(m.let_through);
  }
  const auto responses = responses_beside(*assumptions, messages, let_through);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].response = responses[i];
  return out;
}

std::optional<std::uint64_t> let_through_ppm(const InspectedBuses& buses, std::size_t network) {
  if (network >= buses.assumptions.size() || !buses.assumptions[network]) return std::nullopt;
  std::vector<can::Message> messages;
  for (const BusMessage& m : buses.messages)
    if (m.network == network && m.sent && m.let_through) messages.push_back(*m.sent);
  return can::utilisation_ppm(*buses.assumptions[network], messages);
}

}  // namespace mlcca::core
