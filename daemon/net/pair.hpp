// SPDX-License-Identifier: BSD-2-Clause
// A pair of virtual interfaces: what leaves by one arrives at the other.
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca::net {

struct End {
  std::string name;
  int ifindex = 0;
};

/// In this network namespace, both ends up. `kind`: "vxcan" or "veth". Error: the kernel has no
/// such devices, or one of the names or indices is taken.
Result<void> make_pair(const char* kind, const End& near, const End& far);

}  // namespace mlcca::net
