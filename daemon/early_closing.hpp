// SPDX-License-Identifier: BSD-2-Clause
// mlccad --close: what closes interfaces at boot, and when they appear, before mlccad runs.
#pragma once
#include "daemon/options.hpp"

namespace mlcca {

/// The exit status: 0 where each of them is closed or does not exist. What fails is tried again, at
/// most three times within a second.
int close_early(const Options& options);

}  // namespace mlcca
