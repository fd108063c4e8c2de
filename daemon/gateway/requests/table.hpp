// SPDX-License-Identifier: BSD-2-Clause
// The requests that a gateway answers: who may make each, and who answers it. A request that has no
// row does not compile.
#pragma once
#include "control/messages.hpp"
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

/// Who may make a request.
enum class Privilege : std::uint8_t {
  anyone,  ///< any local user: it only reads
  member,  ///< root and the control group: it changes something
};

/// What a request leaves behind.
enum class Trace : std::uint8_t {
  none,     ///< nothing, or something in memory
  history,  ///< rows of the history, which count against the quota of a user
};

[[nodiscard]] Privilege privilege_of(const control::Request& request);
[[nodiscard]] Trace trace_of(const control::Request& request);
/// So many of these a request makes at least that is not refused.
[[nodiscard]] std::uint64_t least_rows_of(const control::Request& request);
/// It lets less pass than now and nothing more: no quota delays it, and its rows count all the
/// same. What it takes away comes back by requests alone that may have to wait.
[[nodiscard]] bool takes_away(const Context& context, const control::Request& request);
/// Privileges have been checked.
[[nodiscard]] Response handle(Context& context, const Asker& asker,
                              const control::Request& request);

}  // namespace mlcca::requests
