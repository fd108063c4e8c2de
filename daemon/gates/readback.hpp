// SPDX-License-Identifier: BSD-2-Clause
// Reads what is in force from the pins and the kernel, without the daemon. Changes nothing.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bpf/ether.h"
#include "bpf/gate.h"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

/// The memory of an Ethernet gate that its decisions depend on, copied when the gate was read.
struct EtherImage {
  EtherSizes sizes;
  std::vector<ether_table> table;  ///< one element
  std::vector<std::uint64_t> buckets;
  std::vector<ether_prefilter_part> prefilters;
  std::vector<ether_slot> slots;
  std::vector<ether_contract> contracts;
};

/// What was read of one gate.
struct GateReading {
  std::uint32_t ifindex = 0;
  std::string interface;  ///< empty: this network namespace has no interface of this index
  Hook hook = Hook::clsact;
  bool ethernet = false;                      ///< frames carry the subject; false: CAN
  bool wpan = false;                          ///< the frames are those of IEEE 802.15.4
  std::uint32_t profile = GATE_PROFILE_NONE;  ///< CAN only
  std::vector<std::string> problems;          ///< what differs from what the daemon leaves
  bool readable = false;                      ///< whether `slots` could be read
  std::vector<SlotSpec> slots;
  /// The memory from which `slots` were read, because a daemon may change the gate meanwhile.
  std::shared_ptr<const gate_table> can_image;
  std::shared_ptr<const EtherImage> ether_image;
};

/// What was read of all gates, and of the control word.
struct Reading {
  bool open = false;
  bool lapsed = false;
  bool audit = false;
  std::uint32_t generation = 0;
  std::vector<std::string> problems;  ///< problems of what all gates share
  std::vector<GateReading> gates;     ///< sorted by ifindex
};

/// Errors: nothing is pinned at `root`, no permission, another layout.
Result<Reading> read_back(const std::string& root);

}  // namespace mlcca::gates
