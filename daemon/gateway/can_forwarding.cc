// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/can_forwarding.hpp"

#include <fmt/core.h>

#include "daemon/gateway/forwarding.hpp"

namespace mlcca {

CanForwarding::CanForwarding(const Scene& scene, const PortFacts& gates, const LinkMonitor& links,
                             EventLog& log, std::unique_ptr<net::CanRules> kernel,
                             std::function<void()> pulse)
    : scene_(scene),
      gates_(gates),
      links_(links),
      log_(log),
      forwarder_(std::move(kernel),
                 [&log](const std::string& line, bool problem) {
                   if (problem)
                     log.warning(Kind::problem, line);
                   else
                     log.info(Kind::interface, line);
                 }),
      pulse_(std::move(pulse)) {}

void CanForwarding::want(std::size_t channel) {
  std::vector<net::CanRule> rules;
  std::string why;
  if (scene_.state->system().gateways[scene_.self].forwarder != core::Forwarder::none) {
    for (const core::Transit& transit : scene_.state->transits(scene_.self, channel)) {
      const int from = gates_.gated_interface(transit.in.port);
      const int to = gates_.gated_interface(transit.out.port);
      if (from == 0 || to == 0) continue;
      auto made = rules_of(transit, from, to);
      if (made)
        rules.insert(rules.end(), made->begin(), made->end());
      else
        why = fmt::format(
            "{} is not carried from {} to {}: {}", scene_.state->system().channels[channel].name,
            gates_.network_of(transit.in.port), gates_.network_of(transit.out.port), made.error());
    }
  }
  forwarder_.want(channel, std::move(rules));
  const auto known = obstacles_.find(channel);
  if (why.empty()) {
    if (known != obstacles_.end()) obstacles_.erase(known);
  } else if (known == obstacles_.end() || known->second != why) {
    log_.warning(Kind::problem, why);
    obstacles_[channel] = std::move(why);
  }
}

void CanForwarding::want_all() {
  forwarder_.forget();
  const std::size_t channels = scene_.state->decisions().size();
  std::erase_if(obstacles_, [channels](const auto& known) { return known.first >= channels; });
  for (std::size_t c = 0; c < channels; ++c) {
    want(c);
    pulse_();
  }
}

const std::string* CanForwarding::obstacle(std::size_t channel) const {
  const auto known = obstacles_.find(channel);
  return known == obstacles_.end() ? nullptr : &known->second;
}

void CanForwarding::add_to(control::Routes& routes,
                           const Result<std::vector<net::CanRuleThere>>& there) const {
  const auto& channels = scene_.state->system().channels;
  const auto name_of = [&](const net::CanRule& rule) {
    const auto channel = forwarder_.channel_of(rule);
    return channel ? channels[*channel].name : std::string();
  };
  for (const auto& [channel, why] : obstacles_) routes.problems.push_back(why);
  if (!forwarder_.problem().empty()) routes.problems.push_back(forwarder_.problem());
  for (const net::CanRule& rule : forwarder_.in_way())
    routes.problems.push_back(
        fmt::format("{} is also carried by a can-gw rule of another program, from {} to {}",
                    name_of(rule), links_.name_of(rule.from), links_.name_of(rule.to)));
  if (!there) {
    routes.problems.push_back(there.error().text);
    return;
  }
  for (const net::CanRuleThere& t : *there)
    routes.can_rules.push_back({.from = links_.name_of(t.rule.from),
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
