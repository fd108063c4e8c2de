// SPDX-License-Identifier: BSD-2-Clause
// What was granted from one CAN bus to another is carried there by can-gw.
#include <fmt/core.h>

#include <string>
#include <utility>
#include <vector>

#include "daemon/gateway/forwarding.hpp"
#include "daemon/gateway/gateway.hpp"

namespace mlcca {

void Gateway::forward(std::size_t channel) {
  std::vector<net::CanRule> rules;
  std::string why;
  if (scene_.state->system().gateways[scene_.self].forwarder == core::Forwarder::can_gw) {
    for (const core::Transit& transit : scene_.state->transits(scene_.self, channel)) {
      const int from = ports_.gated_interface(transit.in.port);
      const int to = ports_.gated_interface(transit.out.port);
      if (from == 0 || to == 0) continue;
      auto made = rules_of(transit, from, to);
      if (made)
        rules.insert(rules.end(), made->begin(), made->end());
      else
        why = fmt::format(
            "{} is not carried from {} to {}: {}", scene_.state->system().channels[channel].name,
            ports_.network_of(transit.in.port), ports_.network_of(transit.out.port), made.error());
    }
  }
  forwarder_.want(channel, std::move(rules));
  const auto told = not_carried_.find(channel);
  if (why.empty()) {
    if (told != not_carried_.end()) not_carried_.erase(told);
  } else if (told == not_carried_.end() || told->second != why) {
    log_.warning(Kind::trouble, why);
    not_carried_[channel] = std::move(why);
  }
}

void Gateway::forward_all() {
  forwarder_.forget();
  std::erase_if(not_carried_,
                [this](const auto& c) { return c.first >= scene_.state->decisions().size(); });
  for (std::size_t c = 0; c < scene_.state->decisions().size(); ++c) {
    forward(c);
    pulse();
  }
}

void Gateway::add_can_rules(control::Routes& to,
                            const Result<std::vector<net::CanRuleThere>>& there) const {
  const auto& channels = scene_.state->system().channels;
  const auto name_of = [&](const net::CanRule& rule) {
    const auto channel = forwarder_.channel_of(rule);
    return channel ? channels[*channel].name : std::string();
  };
  for (const auto& [channel, why] : not_carried_) to.problems.push_back(why);
  if (!forwarder_.problem().empty()) to.problems.push_back(forwarder_.problem());
  for (const net::CanRule& rule : forwarder_.in_way())
    to.problems.push_back(
        fmt::format("{} is carried by a rule of somebody else, too, from {} to {}", name_of(rule),
                    links_.name_of(rule.from), links_.name_of(rule.to)));
  if (!there) {
    to.problems.push_back(there.error().text);
    return;
  }
  for (const net::CanRuleThere& t : *there)
    to.can_rules.push_back({.from = links_.name_of(t.rule.from),
                            .to = links_.name_of(t.rule.to),
                            .id = t.rule.id,
                            .mask = t.rule.mask,
                            .fd = t.rule.fd,
                            .ours = t.is_ours(),
                            .channel = t.is_ours() ? name_of(t.rule) : std::string(),
                            .change = change_of(t),
                            .hops = t.hops,
                            .handled = t.handled,
                            .dropped = t.dropped,
                            .deleted = t.deleted});
}

}  // namespace mlcca
