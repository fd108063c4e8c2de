// SPDX-License-Identifier: BSD-2-Clause
// mlccad --close: what closes interfaces at boot, and when they appear, before mlccad runs.
#pragma once
#include "daemon/options.hpp"

namespace mlcca {

/// The exit status: 0 where each of them is closed or does not exist; 1 where one may be open,
/// which was tried three times within a second; 2 where a file that names them has a mistake, and
/// what could be read of it is closed.
int close_early(const Options& options);

}  // namespace mlcca
