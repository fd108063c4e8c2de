// SPDX-License-Identifier: BSD-2-Clause
// Any octets as packets of AWDS, as messages of mlcca-sources or mlccad, or as what the kernel says
// of radios, batman-adv and wires; the first octet says which, then pieces follow.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "daemon/net/sources/batman.hpp"
#include "daemon/net/sources/nl80211_view.hpp"
#include "daemon/net/sources/wire.hpp"
#include "tests/fuzz/sources_check.hpp"
#include "tools/sources/awds_packet.hpp"

namespace {

using namespace mlcca;
using fuzz::check;
using fuzz::demand;
using fuzz::kNow;
using fuzz::Pieces;

void awds(Pieces pieces, core::mesh::AwdsMetric metric) {
  net::awds::Graph graph(metric, {"02:00:00:00:00:01"});
  std::uint64_t now = kNow / 2;
  while (!pieces.done()) {
    const auto piece = pieces.next();
    auto topology = net::awds::parse(
        std::span(reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()));
    if (!topology) continue;
    demand(topology->neighbours.size() <= net::awds::kMaxNeighbours);
    now += topology->sequence;
    graph.take(std::move(*topology), now);
  }
  check(graph.snapshot(now));
}

template <class T>
void put(std::vector<T>& into, std::optional<T> read) {
  if (read) into.push_back(std::move(*read));
}

void kernel(Pieces pieces) {
  net::nl80211::View view;
  net::nl80211::Seen radio;
  net::batman::Seen mesh;
  std::optional<net::wire::Interface> wire;
  net::wire::LinkModes modes;
  while (!pieces.done()) {
    const auto piece = pieces.next();
    const auto message = std::as_bytes(std::span(piece.data(), piece.size()));
    if (auto read = net::nl80211::read_interface(message)) radio.interface = std::move(*read);
    put(radio.stations, net::nl80211::read_station(message));
    put(radio.paths, net::nl80211::read_mesh_path(message));
    put(radio.surveys, net::nl80211::read_survey(message));
    put(mesh.interfaces, net::batman::read_hard_interface(message));
    put(mesh.neighbours, net::batman::read_neighbour(message));
    put(mesh.originators, net::batman::read_originator(message));
    if (auto read = net::wire::read_interface(message)) wire = std::move(*read);
    if (auto read = net::wire::read_link_modes(message)) modes = *read;
    check(view.update(radio, kNow));
  }
  check(net::batman::view(mesh, kNow));
  if (wire) check(net::wire::view(*wire, modes, {"a", "b"}, kNow));
}

void facts(Pieces pieces) {
  net::facts::AnswerReader answers;
  net::facts::QuestionReader questions;
  while (!pieces.done()) {
    const auto piece = pieces.next();
    const auto answer = answers.take(piece);
    if (answer && *answer) check(**answer);
    const auto question = questions.take(piece);
    if (!question || !*question) continue;
    const auto again = net::facts::question((*question)->source, (*question)->mesh);
    net::facts::QuestionReader reader;
    for (const auto& message : again) {
      const auto read = reader.take(message);
      demand(read.has_value());
      if (*read) demand((*read)->source == (*question)->source);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Pieces pieces({reinterpret_cast<const char*>(data) + 1, size - 1});
  if (data[0] < 4)
    awds(pieces, static_cast<core::mesh::AwdsMetric>(data[0]));
  else if (data[0] == 'k')
    kernel(pieces);
  else
    facts(pieces);
  return 0;
}
