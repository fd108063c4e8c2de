// SPDX-License-Identifier: BSD-2-Clause
// mlccad --close: closes interfaces at boot and when they appear, before mlccad runs.
#pragma once
#include "daemon/options.hpp"

namespace mlcca {

/// Returns the exit status. 0: each interface is closed or does not exist. 1: one may be open,
/// after three attempts within a second. 2: a file that names interfaces has a mistake; what could
/// be read is closed.
int close_early(const Options& options);

}  // namespace mlcca
