// SPDX-License-Identifier: BSD-2-Clause
// Decisions in process: admissions per second with many reservations in the ledger.
#include <benchmark/benchmark.h>

#include <string>

#include "core/admission/state.hpp"
#include "tests/core/robot.hpp"

namespace {

using namespace mlcca;          // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::core;    // NOLINT(google-build-using-namespace)
using namespace core::testing;  // NOLINT(google-build-using-namespace)

System many(std::size_t channels) {
  System system = robot(0);
  for (Network& n : system.networks) n.provision.set(Attribute::bandwidth, 1'000'000'000'000);
  for (std::size_t i = 1; i < channels; ++i) {
    EventChannel channel = system.channels[0];
    channel.name = "channel-" + std::to_string(i);
    channel.subject += i;
    system.channels.push_back(channel);
    Publisher p = system.publishers[0];
    p.channel = i;
    system.publishers.push_back(p);
    Subscriber s = system.subscribers[0];
    s.channel = i;
    system.subscribers.push_back(s);
    for (Network& n : system.networks) {
      Binding b = n.bindings[0];
      b.channel = i;
      b.id += static_cast<std::uint32_t>(i);
      n.bindings.push_back(b);
    }
  }
  return system;
}

/// One more publisher with its subscriber across the bridge: proposed and dropped (a query).
void propose(benchmark::State& bench) {
  State state(many(static_cast<std::size_t>(bench.range(0))));
  Admission a;
  a.id = 1;
  a.publisher = state.system().publishers[0];
  a.publisher->node = 0x33;
  for (auto _ : bench) {
    const Proposal p = state.propose(a);
    if (!p.fit()) bench.SkipWithError("refused");
  }
  bench.SetItemsProcessed(bench.iterations());
}
BENCHMARK(propose)->Arg(1)->Arg(1000)->Arg(10000);

/// Everything again, as after a change of all networks.
void decide_all_channels(benchmark::State& bench) {
  State state(many(static_cast<std::size_t>(bench.range(0))));
  for (auto _ : bench) state.decide();
  bench.SetItemsProcessed(bench.iterations() * bench.range(0));
}
BENCHMARK(decide_all_channels)->Arg(1000)->Arg(10000);

}  // namespace

BENCHMARK_MAIN();
