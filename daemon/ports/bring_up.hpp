// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/net/links.hpp"

namespace mlcca {

/// Sets the bit rates of a port on an interface that is described as managed, and brings it up.
Result<void> bring_up(const net::Link& link, const core::Port& port, net::Links& links);

}  // namespace mlcca
