// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/sources/proto_emulated.hpp"

#include <cctype>

namespace mlcca::test {
namespace {

void add(Octets& out, const Octets& more) { out.insert(out.end(), more.begin(), more.end()); }

void add_integer(Octets& out, unsigned size, std::uint32_t value) {
  for (unsigned i = size; i-- > 0;) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

Octets node_id(unsigned number) { return {2, 0, 0, 0, 0, static_cast<std::uint8_t>(number)}; }

Octets beacon(unsigned node, std::uint16_t sequence, std::uint16_t period_ms,
              const std::vector<unsigned>& neighbours) {
  Octets out{0};
  add(out, node_id(node));
  add_integer(out, 2, sequence);
  add_integer(out, 2, period_ms);
  out.push_back(0);  // neighbours that are no relays
  out.push_back(static_cast<std::uint8_t>(neighbours.size()));
  for (const unsigned neighbour : neighbours) add(out, node_id(neighbour));
  return out;
}

Octets topology(const TopologyFlood& flood) {
  Octets out{1};
  add(out, node_id(flood.node));
  add_integer(out, 2, flood.sequence);
  add(out, node_id(flood.last_hop));
  out.push_back(flood.ttl);
  out.push_back(0);
  add_integer(out, 4, flood.validity_ms);
  out.push_back(static_cast<std::uint8_t>(flood.qualities.size()));
  for (const auto& [neighbour, quality] : flood.qualities) {
    add(out, node_id(neighbour));
    add_integer(out, 2, quality);
  }
  out.push_back(static_cast<std::uint8_t>(flood.name.size()));
  out.insert(out.end(), flood.name.begin(), flood.name.end());
  return out;
}

Octets octets(const std::string& hexadecimal) {
  Octets out;
  std::string digits;
  for (const char c : hexadecimal) {
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    digits += c;
    if (digits.size() < 2) continue;
    out.push_back(static_cast<std::uint8_t>(std::stoul(digits, nullptr, 16)));
    digits.clear();
  }
  return out;
}

}  // namespace mlcca::test
