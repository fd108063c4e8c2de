// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/bus_monitor.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace mlcca {
namespace {

constexpr std::size_t kChannelsAtOnce = 64;

}  // namespace

void BusMonitor::add_to(std::vector<core::Condition>& conditions) const {
  for (const auto& [network, load] : loads_) {
    if (network >= conditions.size()) continue;
    core::Condition& condition = conditions[network];
    condition.background = BusLoad::at_most(load.unaccounted);
    condition.observed = load.observed;
    for (core::ObservedLoad& observed : condition.observed) {
      observed.load = BusLoad::at_most(observed.load + BusLoad::kStep);
      condition.background += observed.load;
    }
  }
}

BusMonitor::Loads BusMonitor::carry_over(const core::System& former) {
  Loads before = std::exchange(loads_, {});
  for (const auto& [network, load] : before)
    if (const auto place = scene_.state->find_place(former.networks[network].name);
        place && place->kind == core::Place::Kind::network)
      loads_[place->index] = {load.unaccounted, load.reported, {}};
  senders_.clear();
  return before;
}

bool BusMonitor::is_measured(std::size_t port) const {
  const std::size_t network = gates_.network_number(port);
  return scene_.state->ledger().schedule(network) != nullptr &&
         scene_.state->system().networks[network].bus.measured &&
         gates_.bus_counters(port).has_value();
}

bool BusMonitor::poll_some() {
  if (round_.description != scene_.description) round_ = {};
  round_.description = scene_.description;
  const std::size_t port = round_.port;
  if (port >= gates_.size()) {
    if (round_.changed) {
      turn_.observe();
      static_cast<void>(turn_.settle());
    }
    round_ = {};
    return false;
  }
  if (!is_measured(port)) {
    round_.next_port();
    return true;
  }
  const std::size_t channels = scene_.state->decisions().size();
  const std::size_t end = std::min(round_.channel + kChannelsAtOnce, channels);
  for (; round_.channel < end; ++round_.channel)
    poll_refused(scene_.state->decisions()[round_.channel], port);
  if (end < channels) return true;
  round_.changed |= measure(port, std::move(round_.refused));
  round_.next_port();
  return true;
}

/// Measures publishers on the bus of a port that send although nothing of them is granted, as far
/// as the gate distinguishes them.
void BusMonitor::poll_refused(const core::Decision& decision, std::size_t port) {
  const std::size_t network = gates_.network_number(port);
  const core::can::Schedule& bus = *scene_.state->ledger().schedule(network);
  const core::Place here{core::Place::Kind::network, network};
  for (const core::Verdict& v : decision.verdicts) {
    if (scene_.state->members().publisher(v.publisher).place != here ||
        !round_.polled.insert(v.publisher).second)
      continue;
    auto rules = core::gate_state(scene_.state->system(), scene_.state->members(), v, scene_.self);
    std::erase_if(rules, [port](const core::GateRule& rule) {
      return rule.entry.port != port || rule.entry.direction != core::Direction::ingress;
    });
    if (rules.empty()) continue;
    const Frames frames = gates_.frames(rules);
    const std::uint32_t load = senders_[{port, v.publisher}].measure(
        frames.passed + frames.dropped + frames.would_drop, rules.front().entry.frame_length(),
        bus.assumptions().timing.bitrate, clock_.monotonic_ns());
    if (load != 0 && !bus.contains(core::Ledger::key_of({v.publisher, network, core::Flow::kOwn})))
      round_.refused.push_back({v.publisher, load});
  }
}

/// Compares the load of a bus with the analysed one. More means that an unadmitted sender sends, or
/// a publisher sends more than it announced. Frames that the gate drops have been on the bus as
/// well. True if anything has changed.
bool BusMonitor::measure(std::size_t port, std::vector<core::ObservedLoad> senders) {
  const std::size_t network = gates_.network_number(port);
  const core::can::Schedule* bus = scene_.state->ledger().schedule(network);
  const auto counters = gates_.bus_counters(port);
  if (bus == nullptr || !counters) return false;
  Load& load = loads_[network];
  // Expected load: what was declared, the messages of the analysis, and known publishers that are
  // refused.
  std::uint64_t expected =
      bus->utilisation_ppm() -
      std::min<std::uint64_t>(bus->assumptions().background, bus->utilisation_ppm()) +
      scene_.state->system().networks[network].bus.background;
  // The frames of a publisher and those of the bus are not counted at the same moment.
  for (const core::ObservedLoad& sender : senders) expected += sender.load + BusLoad::kStep;
  const std::uint32_t now = meters_[gates_.network_of(port)].measure(
      *counters, bus->assumptions().timing.bitrate, expected, clock_.monotonic_ns());
  if (now == load.unaccounted && senders == load.observed) return false;
  load.unaccounted = now;
  load.observed = std::move(senders);
  // A varying load is reported when it appears, when it disappears, and when it differs much.
  constexpr std::uint32_t large = 200'000;
  const std::uint32_t difference = load.reported > now ? load.reported - now : now - load.reported;
  if ((load.reported == 0) == (now == 0) && difference < large) return true;
  load.reported = now;
  report(gates_.network_of(port), now);
  return true;
}

void BusMonitor::report(const std::string& network, std::uint32_t unaccounted) {
  if (unaccounted != 0)
    log_.warning(Kind::interface,
                 fmt::format("{} carries at least {:.1f} % more than was admitted: a sender "
                             "was not admitted, or sends more than it stated",
                             network, unaccounted / 1e4),
                 {.network = network});
  else
    log_.notice(Kind::interface, fmt::format("{} carries no more than was admitted again", network),
                {.network = network});
}

}  // namespace mlcca
