// SPDX-License-Identifier: BSD-2-Clause
// Packets of AWDS nodes as they go over the air, made by us: nothing here shares code with the
// parser that it tests.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace mlcca::test {

using Octets = std::vector<std::uint8_t>;

/// 02:00:00:00:00:NN
Octets node_id(unsigned number);

/// Beacon of a node that has chosen all of its neighbours as relays.
Octets beacon(unsigned node, std::uint16_t sequence, std::uint16_t period_ms,
              const std::vector<unsigned>& neighbours);

struct TopologyFlood {
  unsigned node = 0;
  std::uint16_t sequence = 0;
  unsigned last_hop = 0;
  std::uint8_t ttl = 32;
  std::uint32_t validity_ms = 0;
  std::map<unsigned, std::uint16_t> qualities;  ///< by neighbour
  std::string name;
};
Octets topology(const TopologyFlood& flood);

/// "00 020000000001 002c": blanks do not count.
Octets octets(const std::string& hexadecimal);

}  // namespace mlcca::test
