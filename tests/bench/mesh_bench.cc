// SPDX-License-Identifier: BSD-2-Clause
// Mesh routes in process: what an admission and a change of links cost in a mesh of 1000 links.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/domains.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/mesh/link_table.hpp"
#include "core/mesh/route.hpp"

namespace {

using namespace mlcca;              // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::core::mesh;  // NOLINT(google-build-using-namespace)

constexpr std::uint32_t kWidth = 16;
constexpr std::uint32_t kHeight = 17;
constexpr Value kRate = 24'000'000;
constexpr Value kVideo = 400'000;  // bytes/s
constexpr Value kEvent = 1000;     // bytes

/// A grid of 16 x 17 nodes, each with a link to each of its neighbours: 1022 directions. Two links
/// apart is two steps, as in a town.
Snapshot grid() {
  Snapshot snapshot;
  const auto name = [](std::uint32_t x, std::uint32_t y) {
    return "02:00:00:00:" + std::to_string(10 + x) + ":" + std::to_string(10 + y);
  };
  const auto both = [&](const std::string& a, const std::string& b) {
    Sample sample;
    sample.rate = kRate;
    sample.channel = 2412;
    sample.from = a;
    sample.to = b;
    snapshot.links.push_back(sample);
    std::swap(sample.from, sample.to);
    snapshot.links.push_back(sample);
  };
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      if (x + 1 < kWidth) both(name(x, y), name(x + 1, y));
      if (y + 1 < kHeight) both(name(x, y), name(x, y + 1));
    }
  return snapshot;
}

Mesh mesh_of_grid() {
  Mesh mesh;
  mesh.interference = Interference::k_hop;
  mesh.packet_time = 170'000;
  mesh.sources.resize(1);
  mesh.sources[0].kind = SourceKind::nl80211;
  return mesh;
}

struct World {
  World() {
    table.take(0, grid(), 1);
    Paths paths(table.graph(), mesh);
    for (std::uint32_t to = 0; route.size() != 4; ++to)
      route = paths.between(*table.node("02:00:00:00:17:18"), to);
  }
  Mesh mesh = mesh_of_grid();
  LinkTable table{mesh};
  std::vector<std::uint32_t> route;
};

Value some(std::size_t domain) { return Value{domain} * 1'000'000; }

/// Four hops whose path is known: what they carry now, and what a flow would take.
void admit_four_hops(benchmark::State& bench) {
  const World world;
  const Domains domains(world.table.graph(), world.mesh);
  const PathCost cost(world.table.graph(), world.mesh, domains, world.route);
  for (auto _ : bench) {
    benchmark::DoNotOptimize(cost.evaluate(kEvent, some));
    benchmark::DoNotOptimize(cost.shares(kVideo, kEvent));
  }
  bench.counters["domains"] = static_cast<double>(cost.shares(kVideo, kEvent).size());
  bench.SetItemsProcessed(bench.iterations());
}
BENCHMARK(admit_four_hops);

/// The same for a path that is met for the first time.
void admit_four_new_hops(benchmark::State& bench) {
  const World world;
  const Domains domains(world.table.graph(), world.mesh);
  for (auto _ : bench) {
    const PathCost cost(world.table.graph(), world.mesh, domains, world.route);
    benchmark::DoNotOptimize(cost.evaluate(kEvent, some));
    benchmark::DoNotOptimize(cost.shares(kVideo, kEvent));
  }
  bench.SetItemsProcessed(bench.iterations());
}
BENCHMARK(admit_four_new_hops);

/// After a change of links: who shares with whom.
void build_domains(benchmark::State& bench) {
  const World world;
  for (auto _ : bench) benchmark::DoNotOptimize(Domains(world.table.graph(), world.mesh));
  bench.counters["links"] = static_cast<double>(world.table.graph().links.size());
}
BENCHMARK(build_domains)->Unit(benchmark::kMicrosecond);

/// All ways from one node.
void search_paths(benchmark::State& bench) {
  const World world;
  for (auto _ : bench) {
    Paths paths(world.table.graph(), world.mesh);
    benchmark::DoNotOptimize(paths.between(0, 100));
  }
}
BENCHMARK(search_paths)->Unit(benchmark::kMicrosecond);

/// A source has polled all links; one of them is slower or faster than before.
void take_samples(benchmark::State& bench) {
  World world;
  Snapshot snapshot = grid();
  std::uint64_t now = 1;
  bool slow = false;
  for (auto _ : bench) {
    slow = !slow;
    now += 1'000'000'000;
    for (Sample& sample : snapshot.links) sample.taken = now;
    snapshot.links[0].rate = slow ? kRate / 2 : kRate;
    benchmark::DoNotOptimize(world.table.take(0, snapshot, now));
  }
  bench.SetItemsProcessed(bench.iterations() * static_cast<std::int64_t>(snapshot.links.size()));
}
BENCHMARK(take_samples)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
