// SPDX-License-Identifier: BSD-2-Clause
// The CAN networks of a description.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/can/of_system.hpp"
#include "core/medium.hpp"
#include "core/topology.hpp"
#include "core/world.hpp"
#include "description/read.hpp"
#include "mlcca/arithmetic.hpp"
#include "tools/design/analyse_bus/bus.hpp"

namespace mlcca::tools::design {
namespace {

using core::Place;
using core::Publisher;
using core::System;

/// How a publisher's events come onto a network.
struct Crossing {
  Value deadline = kUnbounded;  ///< the strictest of all subscribers behind it
  Value jitter = 0;             ///< of the hops before it
  std::uint32_t queue = core::can::kOwnQueue;
};

void tighten(Value& deadline, const AttributeSet& attributes) {
  for (const Attribute a : {Attribute::deadline, Attribute::latency})
    if (attributes.has(a)) deadline = std::min(deadline, attributes[a]);
}

class DescribedBuses {
 public:
  DescribedBuses(const System& system, const BusOptions& options)
      : system_(system), options_(options) {
    const core::Topology topology(system);
    for (std::size_t p = 0; p < system.publishers.size(); ++p)
      for (const core::Subscriber& s : system.subscribers)
        if (s.channel == system.publishers[p].channel) cross(topology, p, s);
  }

  Buses read() && {
    bool any = false;
    for (std::size_t n = 0; n < system_.networks.size(); ++n) {
      const core::Network& network = system_.networks[n];
      if (network.kind != core::NetworkKind::can) continue;
      if (!options_.network.empty() && network.name != options_.network) continue;
      any = true;
      add_network(n);
    }
    if (!any)
      problem({}, options_.network.empty()
                      ? "no CAN network: there is nothing to analyse"
                      : fmt::format("no CAN network '{}': --network must name one of the system",
                                    options_.network));
    if (!problems_.empty()) buses_.clear();
    return {std::move(buses_), std::move(problems_)};
  }

 private:
  void problem(core::Origin origin, const std::string& text) {
    const auto& files = system_.files;
    const std::string file = origin.file < files.size() ? files[origin.file]
                             : files.empty()            ? std::string()
                                                        : files.front();
    problems_.push_back(origin.line > 0 ? fmt::format("{}:{}: {}", file, origin.line, text)
                                        : fmt::format("{}: {}", file, text));
  }

  void cross(const core::Topology& topology, std::size_t publisher, const core::Subscriber& s) {
    const Publisher& p = system_.publishers[publisher];
    const auto& routes = topology.routes(p.place, s.place);
    if (routes.empty()) return;
    const auto hops = core::hops_of(routes.front());
    Value jitter = 0;
    Place before = p.place;
    for (const Place hop : hops) {
      if (hop.kind == Place::Kind::network) {
        Crossing& c = crossings_[{hop.index, publisher}];
        tighten(c.deadline, p.attributes);
        tighten(c.deadline, s.attributes);
        c.jitter = std::max(c.jitter, jitter);
        if (before.kind == Place::Kind::gateway)
          c.queue = core::queue_of(system_, before.index, hop.index);
      }
      const AttributeSet& provision = system_.provision_of(hop);
      if (provision.has(Attribute::jitter))
        jitter = add_saturating(jitter, provision[Attribute::jitter]);
      before = hop;
    }
  }

  void add_network(std::size_t n) {
    const core::Network& network = system_.networks[n];
    auto timing = core::can::timing_of(network);
    if (options_.bitrate != 0) timing.bitrate = options_.bitrate;
    if (options_.data_bitrate != 0) timing.data_bitrate = options_.data_bitrate;
    if (timing.bitrate == 0) {
      problem(network.origin,
              fmt::format("the bit rate of network {} is not described: state it with --bitrate",
                          network.name));
      return;
    }
    Bus bus;
    bus.network = network.name;
    bus.assumptions = core::can::assumptions_of(system_, n, timing);
    if (options_.unknown_senders) bus.assumptions.unknown_senders = true;
    if (options_.background) bus.assumptions.background = *options_.background;
    if (options_.faults) bus.assumptions.faults = *options_.faults;
    for (const auto& [where, crossing] : crossings_)
      if (where.first == n) add_message(bus, n, where.second, crossing);
    buses_.push_back(std::move(bus));
  }

  void add_message(Bus& bus, std::size_t n, std::size_t publisher, const Crossing& crossing) {
    const Publisher& p = system_.publishers[publisher];
    const core::Network& network = system_.networks[n];
    const core::Binding* binding = network.binding_of(p.channel);
    auto message = core::can::message_of(system_, p, 0, n, bus.assumptions.timing);
    if (!message || binding == nullptr) {
      problem(p.origin, why_not(p, network, binding));
      return;
    }
    message->key = publisher;
    message->deadline = crossing.deadline == kUnbounded ? message->period : crossing.deadline;
    message->jitter = add_saturating(message->jitter, crossing.jitter);
    message->queue = crossing.queue;
    BusMessage m;
    m.name = p.name;
    const auto identifier = core::can::identifier_of(p, network, *binding, message->frames > 1);
    m.id = identifier->id;
    m.extended = identifier->extended;
    m.bytes = p.attributes.has(Attribute::max_payload) ? p.attributes[Attribute::max_payload]
                                                       : core::frame_bytes(*binding);
    m.message = *message;
    bus.messages.push_back(std::move(m));
  }

  [[nodiscard]] std::string why_not(const Publisher& p, const core::Network& network,
                                    const core::Binding* binding) const {
    const auto& channel = system_.channels[p.channel].name;
    if (binding == nullptr)
      return fmt::format("channel {} has no Binding on network {}: its frames are not known",
                         channel, network.name);
    if (!p.attributes.has(Attribute::period))
      return fmt::format(
          "publisher {} states no Period: how often it sends on network {} must be "
          "bounded",
          p.name, network.name);
    if (network.profile == core::Profile::none)
      return fmt::format("network {} has no Profile: the identifier of publisher {} is not known",
                         network.name, p.name);
    return fmt::format("publisher {} has no node of network {}: its identifier there is not known",
                       p.name, network.name);
  }

  const System& system_;
  const BusOptions& options_;
  std::map<std::pair<std::size_t, std::size_t>, Crossing> crossings_;  ///< by network, publisher
  std::vector<Bus> buses_;
  std::vector<std::string> problems_;
};

}  // namespace

Buses read_description(const std::string& file, const BusOptions& options) {
  auto examined = description::examine({file}, {}, description::Users::any);
  if (!examined.problems.empty() || !examined.readable) {
    Buses none;
    for (const auto& problem : examined.problems) none.problems.push_back(to_string(problem));
    return none;
  }
  examined.system.sort_bindings();
  return DescribedBuses(examined.system, options).read();
}

}  // namespace mlcca::tools::design
