// SPDX-License-Identifier: BSD-2-Clause
// Prints what a link source reports, a line of JSON for each snapshot, for tests in namespaces and
// in the guest. usage: watch-source KIND INTERFACE|ENDPOINT [ADDRESS...] [--count N] [--until TEXT]
//   KIND       nl80211 batman wire awds babel olsr file description
//   ADDRESS    of the nodes of the mesh
//   --count N  ends after N snapshots
//   --until T  ends after the first line that contains T
// {"at":µs since the epoch,"problem":"…","links":[{"from":…,"to":…,"rate":bit/s,"kind":…,
// "age_ms":…,"loss":…,"channel":…,"busy":…,"weight":…}],"next_hops":[{"from":…,"to":…,"via":…}]}
// Exit status 2: it cannot be watched.
#include <systemd/sd-event.h>

#include <ctime>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "base/handle.hpp"
#include "core/model/words.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  core::mesh::Source source;
  core::mesh::Mesh mesh;
  unsigned long count = 0;  ///< 0: no limit
  std::string until;        ///< empty: nothing is awaited
};

Result<Options> read_options(int argc, char** argv) {
  if (argc < 3) return fail("usage: watch-source KIND INTERFACE|ENDPOINT [ADDRESS...] [OPTION...]");
  Options out;
  const auto kind = core::words::kSourceKinds.find(argv[1]);
  if (!kind) return fail(std::string("no kind of source: ") + argv[1]);
  out.source.kind = *kind;
  out.source.interface = out.source.endpoint = argv[2];
  for (int i = 3; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--count" && i + 1 < argc) {
      out.count = std::stoul(argv[++i]);
    } else if (word == "--until" && i + 1 < argc) {
      out.until = argv[++i];
    } else {
      core::mesh::Node node;
      node.name = node.address = word;
      out.mesh.nodes.push_back(std::move(node));
    }
  }
  return out;
}

std::uint64_t nanos(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000 +
         static_cast<std::uint64_t>(time.tv_nsec);
}

Json describe(const core::mesh::Snapshot& snapshot) {
  const std::uint64_t now = nanos(CLOCK_MONOTONIC);
  Json out{{"at", nanos(CLOCK_REALTIME) / 1000},
           {"problem", snapshot.problem},
           {"links", Json::array()},
           {"next_hops", Json::array()}};
  for (const auto& sample : snapshot.links) {
    Json link{{"from", sample.from},
              {"to", sample.to},
              {"rate", sample.rate},
              {"kind", core::words::kRateKinds.of(sample.kind)},
              {"age_ms", (now - std::min(now, sample.taken)) / 1'000'000}};
    if (sample.loss) link["loss"] = *sample.loss;
    if (sample.channel) link["channel"] = *sample.channel;
    if (sample.busy) link["busy"] = *sample.busy;
    if (sample.weight) link["weight"] = *sample.weight;
    if (sample.valid) link["valid_ms"] = *sample.valid / 1'000'000;
    out["links"].push_back(std::move(link));
  }
  for (const auto& hop : snapshot.next_hops)
    out["next_hops"].push_back({{"from", hop.from}, {"to", hop.to}, {"via", hop.via}});
  return out;
}

int watch(const Options& options) {
  sd_event* raw = nullptr;
  if (sd_event_new(&raw) < 0) return 2;
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  unsigned long reports = 0;
  const auto source = net::open_source(
      options.source, options.mesh, loop.get(), [&](const core::mesh::Snapshot& snapshot) {
        const std::string line = describe(snapshot).dump();
        std::cout << line << std::endl;  // a test waits for it
        ++reports;
        const bool found = !options.until.empty() && line.find(options.until) != std::string::npos;
        if (found || reports == options.count) sd_event_exit(loop.get(), 0);
      });
  if (!source) {
    std::cerr << source.error().text << '\n';
    return 2;
  }
  return sd_event_loop(loop.get()) < 0 ? 2 : 0;
}

}  // namespace
}  // namespace mlcca

int main(int argc, char** argv) {
  const auto options = mlcca::read_options(argc, argv);
  if (!options) {
    std::cerr << options.error().text << '\n';
    return 2;
  }
  return mlcca::watch(*options);
}
