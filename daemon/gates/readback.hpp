// SPDX-License-Identifier: BSD-2-Clause
// What is in force, read back from the pins and the kernel without the daemon. Changes nothing.
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

namespace mlcca::enforce {

/// The memory of an Ethernet gate that decides, as it was when the gate was read.
struct EtherImage {
  EtherSizes sizes;
  std::vector<ether_table> table;  ///< one
  std::vector<std::uint64_t> buckets;
  std::vector<ether_prefilter_part> prefilters;
  std::vector<ether_slot> slots;
  std::vector<ether_contract> contracts;
};

struct GateReading {
  std::uint32_t ifindex = 0;
  std::string interface;  ///< empty: there is none of this index in this network namespace
  Hook hook = Hook::clsact;
  bool ethernet = false;                      ///< frames carry the subject; else CAN
  bool wpan = false;                          ///< these are of IEEE 802.15.4
  std::uint32_t profile = GATE_PROFILE_NONE;  ///< CAN only
  std::vector<std::string> problems;          ///< what is not as the daemon leaves it
  bool readable = false;                      ///< `slots` are those that it has
  std::vector<SlotSpec> slots;
  /// What `slots` were read from: a daemon goes on to change the gate itself.
  std::shared_ptr<const gate_table> can_image;
  std::shared_ptr<const EtherImage> ether_image;
};

struct Reading {
  bool open = false;
  bool lapsed = false;
  bool audit = false;
  std::uint32_t generation = 0;
  std::vector<std::string> problems;  ///< of what all gates share
  std::vector<GateReading> gates;     ///< by ifindex
};

/// Errors: nothing is pinned there, no permission, another layout.
Result<Reading> read_back(const std::string& root);

}  // namespace mlcca::enforce
