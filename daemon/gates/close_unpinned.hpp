// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"

namespace mlcca::gates {

/// An interface that has a program of a gate, of any daemon.
struct GatedInterface {
  std::uint32_t ifindex = 0;
  std::string name;
  Hook hook = Hook::clsact;
  bool passes = false;  ///< it may pass frames; false: its programs are those of mlccad --close,
                        ///< which drop everything
};
/// The gated interfaces of this network namespace, pinned or not. The error: they cannot be found
/// out.
Result<std::vector<GatedInterface>> gated_interfaces();

/// Whether both directions have a program of a gate, of any daemon. False if that cannot be found
/// out.
bool is_gated(std::uint32_t ifindex, Hook hook);

/// For a daemon that cannot command the gates because there is no bpffs: replaces all gates of this
/// network namespace by closed ones, which stay until a daemon replaces them. Returns the names of
/// those interfaces. The error names those that could not be closed; the others are closed.
Result<std::vector<std::string>> close_unpinned();

}  // namespace mlcca::gates
