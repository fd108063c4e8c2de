// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_deadlines.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "core/design/inspect.hpp"
#include "description/read.hpp"
#include "tools/design/queue_lengths.hpp"

namespace mlcca::tools::design {
namespace {

/// The longest response time of a channel on each bus, ns; nothing: it has no bound there.
using OnBuses = std::map<std::size_t, std::map<std::size_t, std::optional<std::uint64_t>>>;

OnBuses responses_of(const core::System& system, const core::InspectedBuses& buses) {
  OnBuses out;
  for (std::size_t n = 0; n < buses.assumptions.size(); ++n) {
    for (const core::SentMessage& sent : core::all_sent(buses, n)) {
      const std::size_t channel = system.publishers[sent.message->publisher].channel;
      auto [at, fresh] = out[channel].try_emplace(n, std::uint64_t{0});
      if (!sent.response.bounded)
        at->second.reset();
      else if (at->second)
        at->second = std::max<std::uint64_t>(*at->second, sent.response.response);
    }
  }
  return out;
}

}  // namespace

std::set<std::string> too_often_for_transport(const core::System& system) {
  core::InspectedBuses buses;
  std::ignore = core::inspect(system, {}, {}, &buses);
  std::set<std::string> out;
  for (std::size_t n = 0; n < buses.assumptions.size(); ++n)
    for (const core::SentMessage& sent : core::all_sent(buses, n))
      if (!sent.response.bounded && sent.message->message && sent.message->message->pauses != 0)
        out.insert(system.channels[system.publishers[sent.message->publisher].channel].name);
  return out;
}

std::map<std::string, std::uint64_t> deadlines_that_hold(const core::System& system) {
  core::InspectedBuses buses;
  std::ignore = core::inspect(system, {}, {}, &buses);
  std::map<std::string, std::uint64_t> out;
  for (const auto& [channel, on_buses] : responses_of(system, buses)) {
    // Each gateway between two buses takes what its Provision says.
    std::uint64_t takes = 0;
    for (const core::Gateway& gateway : system.gateways)
      if (on_buses.size() > 1) takes += gateway.provision[Attribute::latency];
    bool bounded = true;
    for (const auto& [bus, response] : on_buses) {
      bounded = bounded && response.has_value();
      takes += response.value_or(0);
    }
    const core::EventChannel& c = system.channels[channel];
    if (bounded && takes > c.attributes[Attribute::period]) out.emplace(c.name, takes + takes / 4);
  }
  return out;
}

learn::Draft draft_that_holds(const learn::Observer& observer,
                              const std::vector<std::string>& names, learn::DraftOptions options) {
  learn::Draft draft = learn::draft_of(observer, names, options);
  auto system = description::read_memory(draft.xml, "draft", {}, description::Users::any);
  if (!system) return draft;  // who asked for it says why it cannot be read
  system->sort_bindings();
  options.at_mean = too_often_for_transport(*system);
  if (!options.at_mean.empty()) {
    draft = learn::draft_of(observer, names, options);
    system = description::read_memory(draft.xml, "draft", {}, description::Users::any);
    if (!system) return draft;
    system->sort_bindings();
  }
  const auto lengthen = [&] {
    const auto lengths = lengthen_queues(*system);
    for (const auto& [network, frames] : lengths) options.waiting[names[network]] = frames;
    return !lengths.empty();
  };
  const bool longer = lengthen();
  options.deadlines = deadlines_that_hold(*system);
  if (!longer && options.deadlines.empty()) return draft;
  draft = learn::draft_of(observer, names, options);
  system = description::read_memory(draft.xml, "draft", {}, description::Users::any);
  if (!system) return draft;
  system->sort_bindings();
  // What is in time now is granted, and waits, too.
  return lengthen() ? learn::draft_of(observer, names, options) : draft;
}

}  // namespace mlcca::tools::design
