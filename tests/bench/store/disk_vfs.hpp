// SPDX-License-Identifier: BSD-2-Clause
// SQLite on a Disk: so it can be crashed as the journal is.
#pragma once
#include "daemon/store/disk.hpp"

namespace mlcca::bench {

/// From now on SQLite's layer of the name kDiskVfs uses this disk, which must outlive every
/// database that is opened there. When the disk loses its power every call fails.
void use_disk(store::Disk& disk);
inline constexpr const char* kDiskVfs = "disk";
/// The power is gone.
bool power_is_gone();

}  // namespace mlcca::bench
