// SPDX-License-Identifier: BSD-2-Clause
// A reply with a long list is sent in slices; see Reply.more in control.proto.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"

namespace mlcca::control {

/// Appends a slice to what came before it; `whole.more` then says whether another one follows. An
/// Error slice replaces everything. Fails if the slice is of another kind of reply.
Result<void> join(std::optional<Reply>& whole, Reply slice);

/// Divides a reply into slices of about `rows` rows each; returns at least one. A reply without a
/// list, or one that was made in slices from the beginning, stays as it is. A gate or resource that
/// continues in the next slice is repeated there with its name.
std::vector<Reply> slices_of(Reply whole, std::size_t rows);

}  // namespace mlcca::control
