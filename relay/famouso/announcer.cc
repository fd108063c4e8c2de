// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/announcer.hpp"

#include <algorithm>
#include <variant>

namespace mlcca::relay {

void Announcer::daemon_gone() {
  asked_ = 0;
  own_ = {};
}

void Announcer::announce() {
  if (own_.interval_ns == 0) return;
  const Announcement own{.gateway = own_.gateway,
                         .lasts_ns = own_.lasts_ns,
                         .forwards = own_.forwards,
                         .not_received = own_.not_received};
  for (const std::string& network : own_.networks)
    outside_.send(network, encode(own, outside_.longest(network)));
}

void Announcer::turn(std::uint64_t now) {
  if (asked_ != 0 || now < due_at_) return;
  asked_ = outside_.ask({});
  due_at_ = now + (own_.interval_ns != 0 ? own_.interval_ns : kAskAgain);
}

bool Announcer::answered(std::uint64_t request, const control::Reply& reply, std::uint64_t now) {
  if (request == 0 || request != asked_) return false;
  asked_ = 0;
  const auto* said = std::get_if<control::Presence>(&reply.body);
  own_ = said != nullptr ? *said : control::Presence{};
  due_at_ = std::min(due_at_, now + (own_.interval_ns != 0 ? own_.interval_ns : kAskAgain));
  announce();
  return true;
}

bool Announcer::receive(const std::string& network, Octets event, std::uint64_t now) {
  auto message = parse_announcement(event);
  if (!message) return false;
  // Only known gateways and networks are stored in passed_on_, which bounds it.
  if (std::ranges::find(own_.others, message->gateway) == own_.others.end() ||
      std::ranges::find(own_.networks, network) == own_.networks.end())
    return true;
  const auto [at, first] = passed_on_.try_emplace({network, message->gateway}, now);
  if (!first && now - at->second < kPause) return true;
  at->second = now;
  constexpr std::size_t most = 16;  // as PresenceRequest allows
  if (message->not_received.size() > most) message->not_received.resize(most);
  outside_.ask({.network = network,
                .gateway = std::move(message->gateway),
                .lasts_ns = message->lasts_ns,
                .forwards = message->forwards,
                .not_received = std::move(message->not_received)});
  return true;
}

}  // namespace mlcca::relay
