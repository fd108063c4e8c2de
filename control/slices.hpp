// SPDX-License-Identifier: BSD-2-Clause
// A reply with a long list comes in slices, see Reply.more in control.proto.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"

namespace mlcca::control {

/// Puts a slice behind what came before it; `whole.more` says whether there is another one. An
/// error takes the place of everything. Fails if the slice is of another kind of reply.
Result<void> join(std::optional<Reply>& whole, Reply slice);

/// Slices of about `rows` rows, at least one; what has no list, or is made in slices from the
/// beginning, stays whole. A gate or a resource that goes on in the next slice is repeated there
/// with its name and further rows.
std::vector<Reply> split(Reply whole, std::size_t rows);

}  // namespace mlcca::control
