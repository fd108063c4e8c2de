// SPDX-License-Identifier: BSD-2-Clause
// The rules for gateways that announce their presence.
#include "core/model/presence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <set>

#include "core/gates/control_traffic.hpp"
#include "core/model/medium.hpp"
#include "core/profiles/profile.hpp"
#include "description/rules.hpp"

namespace mlcca::description {
namespace {

constexpr Value kSecond = 1'000'000'000;
constexpr Value kAnnouncementHeader = 20;    // octets, with the length of the name
constexpr Value kLongestAnnouncement = 256;  // octets

class PresenceRules {
 public:
  PresenceRules(const core::System& system, Problems& problems)
      : system_(system), problems_(problems) {}

  void run() {
    for (std::size_t g = 0; g < system_.gateways.size(); ++g)
      if (system_.gateways[g].presence != 0) check(g);
    for (const std::size_t n : on_can_) check_rate(n);
  }

 private:
  void say(const core::Origin& origin, const char* element, const std::string& text) {
    problems_.add(origin, element, text, core::FindingId::wrong_place);
  }

  void check(std::size_t g) {
    const core::Gateway& gateway = system_.gateways[g];
    std::set<std::size_t> networks;
    for (std::size_t other = 0; other < system_.gateways.size(); ++other) {
      if (other == g) continue;
      const auto shared = core::presence_networks(system_, g, other);
      networks.insert(shared.begin(), shared.end());
    }
    if (networks.empty())
      say(gateway.origin, "Gateway",
          fmt::format("nobody receives the presence of {}: another Gateway needs a presence, and a "
                      "network of both needs Subscriptions",
                      gateway.name));
    for (const std::size_t n : networks) check_port(gateway, n);
  }

  void check_port(const core::Gateway& gateway, std::size_t n) {
    const core::Network& network = system_.networks[n];
    const core::Port& port = *gateway.port_on(n);
    if (port.control_uid == 0)
      say(port.origin, "Port",
          fmt::format("{} announces itself on {} by a program of the control-user: state "
                      "control-user=\"mlcca-famouso\"",
                      gateway.name, network.name));
    if (network.kind != core::NetworkKind::can) return;
    on_can_.insert(n);
    if (!port.node)
      say(port.origin, "Port",
          fmt::format("{} announces itself on {}, where every frame has a sender: state a node",
                      gateway.name, network.name));
  }

  /// Checks that the rate limit of control traffic suffices for the announcements.
  void check_rate(std::size_t n) {
    const core::Network& network = system_.networks[n];
    const core::ProfileTraits& traits = core::traits_of(network.profile);
    const auto kind = std::ranges::find_if(traits.control, &core::ControlKind::is_tagged);
    if (kind == traits.control.end() || traits.fragmentation == nullptr) return;
    const auto index = static_cast<std::size_t>(kind - traits.control.begin());
    Value names = 0;
    for (const core::Gateway& gateway : system_.gateways)
      if (gateway.presence != 0 && gateway.port_on(n) != nullptr) names += 1 + gateway.name.size();
    const Value frames = traits.fragmentation->frames(
        std::min(kAnnouncementHeader + names, kLongestAnnouncement), core::kClassicBytes);
    Value rate = 0;
    const core::Port* slowest = nullptr;
    for (const core::Gateway& gateway : system_.gateways) {
      const core::Port* const port = gateway.port_on(n);
      if (gateway.presence == 0 || port == nullptr) continue;
      rate += (frames * kSecond + gateway.presence - 1) / gateway.presence;
      if (slowest == nullptr || core::control_at(network, *port, index).rate <
                                    core::control_at(network, *slowest, index).rate)
        slowest = port;
    }
    if (slowest == nullptr) return;
    const Value most = core::control_at(network, *slowest, index).rate;
    if (rate > most)
      say(slowest->origin, "Port",
          fmt::format("gateways announce themselves on {} with up to {} frames of {} in a second, "
                      "and {} may pass: state a longer presence or a greater control-rate",
                      network.name, rate, kind->name, most));
  }

  const core::System& system_;
  Problems& problems_;
  std::set<std::size_t> on_can_;
};

}  // namespace

void check_presence(const core::System& system, Problems& problems) {
  PresenceRules(system, problems).run();
}

}  // namespace mlcca::description
