// SPDX-License-Identifier: BSD-2-Clause
// Who commands the gates of a bpffs: one process, of the user that the bpffs belongs to.
#pragma once
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca {

/// Held while the descriptor is open. `root`: the bpffs. What is locked is the directory
/// `root`/lock, which only its owner can open: a user that may only read the bpffs cannot keep a
/// daemon from starting. Errors: another process commands the gates; what we would use there
/// belongs, or can come to belong, to another user. Where `root` is no bpffs nothing is locked, for
/// there is nothing to command.
Result<Fd> lock_gates(const std::string& root);
/// Where another program removed the directory that is locked, or mounted the bpffs again: locks
/// the one that has the name now. True: it did. Error: another process commands the gates there.
Result<bool> keep_lock(Fd& lock, const std::string& root);

}  // namespace mlcca
