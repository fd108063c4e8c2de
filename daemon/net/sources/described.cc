// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/described.hpp"

#include <utility>

#include "daemon/net/sources/timer.hpp"

namespace mlcca::net {
namespace {

class DescribedSource final : public LinkSource {
 public:
  DescribedSource(std::vector<core::mesh::Sample> links, Report report)
      : report_(std::move(report)), links_(std::move(links)) {}

  Result<void> start(sd_event* loop) {
    return timer_.start(loop, [this, loop] {
      core::mesh::Snapshot snapshot{.links = links_, .next_hops = {}, .problem = {}};
      stamp(snapshot, time_of(loop));
      timer_.set(kPollInterval);
      report_(std::move(snapshot));
    });
  }

 private:
  Report report_;
  std::vector<core::mesh::Sample> links_;
  Timer timer_;
};

}  // namespace

std::vector<core::mesh::Sample> described_links(const core::mesh::Mesh& mesh) {
  std::vector<core::mesh::Sample> out;
  for (const auto& link : mesh.links) {
    core::mesh::Sample sample;
    sample.from = mesh.nodes[link.from].address;
    sample.to = mesh.nodes[link.to].address;
    sample.rate = link.rate;
    sample.kind = link.kind;
    sample.loss = link.loss;
    sample.channel = link.channel;
    out.push_back(std::move(sample));
  }
  return out;
}

Result<std::unique_ptr<LinkSource>> open_described(const core::mesh::Mesh& mesh, sd_event* loop,
                                                   LinkSource::Report report) {
  auto source = std::make_unique<DescribedSource>(described_links(mesh), std::move(report));
  if (auto started = source->start(loop); !started) return std::unexpected(started.error());
  return source;
}

}  // namespace mlcca::net
