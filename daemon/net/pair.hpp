// SPDX-License-Identifier: BSD-2-Clause
// A pair of virtual interfaces: frames that leave by one arrive at the other.
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca::net {

/// One end of the pair: the name and index that it is to have.
struct End {
  std::string name;
  int ifindex = 0;
};

/// Makes a pair in this network namespace and brings both ends up. `kind` is "vxcan" or "veth". The
/// error: the kernel has no such devices, or a name or index is in use.
Result<void> make_pair(const char* kind, const End& near, const End& far);

}  // namespace mlcca::net
