// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/report_size.hpp"

#include <algorithm>

#include "control/messages.hpp"

namespace mlcca {
namespace {

constexpr std::size_t kOfADelivery = 4;   // the lines for its names, reason and counters
constexpr std::size_t kHopsOfALine = 16;  // hops that are evaluated in the time of one line

std::size_t lines_of_medium(const core::State& state, const core::MediumUse& use) {
  std::size_t lines = 1;
  const auto& view = state.world().meshes[use.network];
  if (!view) return lines;
  for (const auto& [from, to] : use.pairs) lines += 1 + view->path(from, to).size() / kHopsOfALine;
  return lines;
}

std::size_t lines_of_meshes(const core::State& state) {
  std::size_t lines = 0;
  for (const core::Network& network : state.system().networks)
    if (network.mesh)
      lines +=
          network.mesh->nodes.size() + network.mesh->links.size() + network.mesh->domains.size();
  for (const auto& view : state.world().meshes)
    if (view) lines += view->addresses.size() + view->graph.links.size() + view->domains().count();
  return lines;
}

std::size_t lines_of_channel(const core::State& state, std::size_t channel, std::size_t most) {
  std::size_t lines = 0;
  for (const core::Verdict& v : state.decisions()[channel].verdicts) {
    if (lines > most) return lines;
    lines += lines_of(state, v);
  }
  for (const std::size_t publisher : state.members().publishers_of(channel)) {
    if (lines > most) return lines;
    ++lines;
    for (const core::Holding& h : state.ledger().holdings_of(publisher))
      lines += 1 + (h.mesh ? h.mesh->shares.size() : 0);
  }
  return lines;
}

}  // namespace

std::size_t lines_of(const core::State& state, const core::Verdict& v) {
  std::size_t lines = kOfADelivery +
                      std::min(v.subscribers.size(), control::Channel::kMostSubscribers) +
                      std::min(v.rows.size(), control::Channel::kMostRows) + v.route.size();
  for (const core::MediumUse& use : v.media) lines += lines_of_medium(state, use);
  return lines;
}

std::size_t lines_of(const core::State& state, std::size_t most) {
  const core::System& system = state.system();
  std::size_t lines = system.networks.size() + system.gateways.size() + state.decisions().size();
  if (lines <= most) lines += lines_of_meshes(state);
  for (std::size_t c = 0; c < state.decisions().size() && lines <= most; ++c)
    lines += lines_of_channel(state, c, most - lines);
  return lines;
}

std::uint32_t leave_out(const core::State& state, std::vector<const core::Verdict*>& deliveries) {
  const auto until_full = [&] {
    std::size_t lines = 0;
    std::size_t listed = 0;
    for (const core::Verdict* v : deliveries) {
      lines += lines_of(state, *v);
      if (lines > kMostLines && listed != 0) break;
      ++listed;
    }
    return listed;
  };
  if (until_full() == deliveries.size()) return 0;
  std::ranges::stable_partition(deliveries, [](const core::Verdict* v) { return !v->granted; });
  const std::size_t listed = until_full();
  const std::size_t left_out = deliveries.size() - listed;
  deliveries.resize(listed);
  return static_cast<std::uint32_t>(left_out);
}

}  // namespace mlcca
