// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"

namespace mlcca::enforce {

/// An interface that has a program of a gate, of whatever daemon.
struct GatedInterface {
  std::uint32_t ifindex = 0;
  std::string name;
  Hook hook = Hook::clsact;
  bool passes = false;  ///< it may pass something; else it is one that mlccad --close has put there
};
/// All of this network namespace, pinned or not. Error: it cannot be known.
Result<std::vector<GatedInterface>> gated_interfaces();

/// Both directions have the program of a gate, of whatever daemon. False where that cannot be
/// known.
bool is_gated(std::uint32_t ifindex, Hook hook);

/// For a daemon that cannot command the gates, because there is no bpffs: puts closed ones in the
/// place of all that are in this network namespace, where they stay until a daemon replaces them.
/// Gives the names of those interfaces. Error: it names those that could not be closed, and closed
/// the others.
Result<std::vector<std::string>> close_unpinned();

}  // namespace mlcca::enforce
