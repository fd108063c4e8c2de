// SPDX-License-Identifier: BSD-2-Clause
// The lock of a bpffs: only one process commands its gates, and it must be of the user who owns the
// bpffs.
#pragma once
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca {

/// Locks the gates of the bpffs at `root` while the descriptor is open. The lock is on the
/// directory `root`/lock, which only its owner can open, so a user who may only read the bpffs
/// cannot keep a daemon from starting. Errors: another process commands the gates; something that
/// we would use there belongs, or could come to belong, to another user. If `root` is not a bpffs,
/// nothing is locked, because there are no gates to command.
Result<Fd> lock_gates(const std::string& root);
/// If another program has removed the locked directory, or mounted the bpffs again: locks the
/// directory that has the name now. True if it did so. The error: another process commands the
/// gates there.
Result<bool> keep_lock(Fd& lock, const std::string& root);

}  // namespace mlcca
