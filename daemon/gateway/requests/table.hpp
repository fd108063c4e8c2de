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
/// Privileges have been checked.
[[nodiscard]] Response handle(Context& context, const Asker& asker,
                              const control::Request& request);

}  // namespace mlcca::requests
