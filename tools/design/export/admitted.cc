// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/export/admitted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "core/design/inspect.hpp"
#include "core/gates/plan.hpp"
#include "core/model/text.hpp"

namespace mlcca::tools::design {
namespace {

template <class End>
std::string name_of_end(const core::System& system, const End& end) {
  return end.component == core::kNoComponent ? end.name : system.components[end.component].name;
}

class FramesOnNetwork {
 public:
  FramesOnNetwork(const Admitted& admitted, std::size_t network, Lacks& lacks)
      : system_(admitted.system()),
        here_{core::Place::Kind::network, network},
        network_(system_.networks[network]),
        lacks_(lacks) {}

  void add(std::size_t channel, const core::Decision& decision) {
    const auto* binding = network_.binding_of(channel);
    if (binding == nullptr) return;
    const auto before = frames_.size();
    for (const auto& verdict : decision.verdicts) {
      const auto at = std::ranges::find(verdict.route, here_);
      if (verdict.granted && at != verdict.route.end()) add(verdict, *binding, at);
    }
    if (frames_.size() == before)
      lacks_.add("not-admitted",
                 "the channel is bound on the network, and nobody is admitted to it", 0,
                 fmt::format("{} on {}", system_.channels[channel].name, network_.name));
  }

  std::vector<AdmittedFrames> take() { return std::move(frames_); }

 private:
  using At = core::Route::const_iterator;

  void add(const core::Verdict& verdict, const core::Binding& binding, At at) {
    const auto& publisher = system_.publishers[verdict.publisher];
    auto found = known_.find(verdict.publisher);
    if (found == known_.end()) {
      const auto identity = core::identity_of(publisher, network_, binding, false);
      if (!identity) return;
      const bool forwarded = at != verdict.route.begin();
      frames_.push_back({.channel = verdict.channel,
                         .publisher = verdict.publisher,
                         .set = verdict.set,
                         .identity = *identity,
                         .sender = forwarded ? system_.gateways[std::prev(at)->index].name
                                             : name_of_end(system_, publisher),
                         .receivers = {}});
      found = known_.emplace(verdict.publisher, frames_.size() - 1).first;
    }
    auto& receivers = frames_[found->second].receivers;
    const auto receive = [&](const std::string& name) {
      if (std::ranges::find(receivers, name) == receivers.end()) receivers.push_back(name);
    };
    if (std::next(at) != verdict.route.end())
      return receive(system_.gateways[std::next(at)->index].name);
    for (const auto s : verdict.subscribers) receive(name_of_end(system_, system_.subscribers[s]));
  }

  const core::System& system_;
  core::Place here_;
  const core::Network& network_;
  Lacks& lacks_;
  std::vector<AdmittedFrames> frames_;
  std::map<std::size_t, std::size_t> known_;  ///< index of the frames by publisher
};

/// Lists refused deliveries that would cross the gateway, and those that have no route.
void list_refused(const Admitted& admitted, const core::Decision& decision, core::Place gateway,
                  Lacks& lacks) {
  const auto& system = admitted.system();
  for (const core::Verdict& v : decision.verdicts)
    if (!v.granted && (v.route.empty() || std::ranges::find(v.route, gateway) != v.route.end()))
      lacks.add(
          "refused", "is not admitted: left out", 0,
          fmt::format("{} of {} to {}", system.channels[v.channel].name,
                      admitted.members().publisher(v.publisher).name, core::name_of(system, v.to)));
}

}  // namespace

Admitted::Admitted(const core::System& system)
    : system_(system), members_(system), decisions_(system.channels.size()) {
  std::vector<bool> known(system.channels.size(), false);
  const auto keep = [&](std::size_t channel, const core::Decision& decision,
                        std::span<const core::Finding>) {
    if (known[channel]) return;  // the first call is for the set in use
    known[channel] = true;
    decisions_[channel] = decision;
  };
  static_cast<void>(core::inspect(system, {}, keep));
}

std::vector<AdmittedFrames> frames_on(const Admitted& admitted, std::size_t network, Lacks& lacks) {
  FramesOnNetwork frames(admitted, network, lacks);
  for (std::size_t c = 0; c < admitted.decisions().size(); ++c)
    frames.add(c, admitted.decisions()[c]);
  return frames.take();
}

void list_not_carried(const Admitted& admitted, std::size_t gateway, Lacks& lacks) {
  const auto& system = admitted.system();
  const auto& ports = system.gateways[gateway].ports;
  const auto is_can = [&](std::size_t port) {
    return system.networks[ports[port].network].kind == core::NetworkKind::can;
  };
  for (std::size_t c = 0; c < admitted.decisions().size(); ++c) {
    const core::Decision& decision = admitted.decisions()[c];
    list_refused(admitted, decision, {core::Place::Kind::gateway, gateway}, lacks);
    std::set<std::pair<std::size_t, std::size_t>> ways;  // pairs of ports
    for (const core::Passage& passage :
         core::passages(system, admitted.members(), c, decision.verdicts, gateway))
      if (passage.in && passage.out && !(is_can(passage.in->port) && is_can(passage.out->port)))
        ways.emplace(passage.in->port, passage.out->port);
    for (const auto& [in, out] : ways)
      lacks.add("relay", "is carried by mlcca-relay alone: left out", 0,
                fmt::format("{} from {} to {}", system.channels[c].name,
                            system.networks[ports[in].network].name,
                            system.networks[ports[out].network].name));
  }
}

}  // namespace mlcca::tools::design
