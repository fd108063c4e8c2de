// SPDX-License-Identifier: BSD-2-Clause
// Any text as what babeld or olsrd2 answers, as a file of links, or as the kernel's list of
// sockets; the first octet says which.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/sources_check.hpp"
#include "tools/sources/babel.hpp"
#include "tools/sources/file.hpp"
#include "tools/sources/olsr.hpp"
#include "tools/sources/peer.hpp"

namespace {

using namespace mlcca;
using fuzz::check;
using fuzz::demand;

void babel(std::string_view text) {
  net::babel::State state({"a", "10.0.0.1", "fe80::1"});
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    state.take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  const auto snapshot = state.snapshot();
  demand(snapshot.links.size() <= 2 * net::babel::kMaxNeighbours);
  demand(snapshot.next_hops.size() <= net::babel::kMaxRoutes);
  check(snapshot);
}

void olsr(std::string_view text) {
  const auto read = net::olsr::parse(text);
  if (!read) {
    demand(!read.error().text.empty());
    return;
  }
  for (const auto& s : read->links) demand(s.rate <= Value{1} << 31U && s.weight);
  check(*read);
}

void file(std::string_view text) {
  core::mesh::Mesh mesh;
  for (const char* name : {"a", "b", "c"}) {
    core::mesh::Node node;
    node.name = name;
    node.address = std::string("10.0.0.") + name;
    mesh.nodes.push_back(node);
  }
  const auto links = net::parse_links(text, "f", mesh);
  if (!links) return;
  demand(links->size() <= 6);  // each direction once
  for (const auto& s : *links)
    demand(s.rate > 0 && s.rate <= core::mesh::kMaxRate && s.from != s.to);
  core::mesh::Snapshot snapshot;
  snapshot.links = *links;
  check(snapshot);
}

void sockets(std::string_view text) {
  for (const char* endpoint : {"127.0.0.1:2009", "[::1]:33123"}) {
    net::Reachable reachable(*net::parse_endpoint(endpoint));
    for (std::string_view rest = text; !rest.empty();) {
      const auto end = std::min(rest.find('\n'), rest.size());
      reachable.take(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    demand(reachable.listeners().size() <= text.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'b':
      babel(text);
      break;
    case 'o':
      olsr(text);
      break;
    case 'f':
      file(text);
      break;
    default:
      sockets(text);
  }
  return 0;
}
