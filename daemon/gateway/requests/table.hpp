// SPDX-License-Identifier: BSD-2-Clause
// The table of requests that a gateway answers: who may make each, and its handler. A request
// without a row does not compile.
#pragma once
#include <cstdint>

#include "control/messages.hpp"
#include "daemon/gateway/requests/context.hpp"
#include "daemon/gateway/requests/response.hpp"

namespace mlcca::requests {

/// Who may make a request.
enum class Privilege : std::uint8_t {
  anyone,   ///< any local user: nothing that passes and nothing that is reported changes by it
  program,  ///< programs of the users that the description names; the handler refuses all others
  member,   ///< root and the control group
};

/// What a request leaves behind.
enum class Trace : std::uint8_t {
  none,               ///< nothing, or only something in memory
  history,            ///< rows of the history, which are charged to the quota of the user
  history_of_reload,  ///< the same, at least as many rows as a reload makes
};

[[nodiscard]] Privilege privilege_of(const control::Request& request);
[[nodiscard]] Trace trace_of(const control::Request& request);
/// The least number of rows that a request of this kind makes in the history if it is not refused.
[[nodiscard]] std::uint64_t least_rows_of(const control::Request& request);
/// Whether the request only lets less pass than now. No quota delays such a request, but its rows
/// count. What it takes away can only be restored by requests that may have to wait.
[[nodiscard]] bool takes_away(const Context& context, const control::Request& request);
/// Answers a request whose privilege has been checked.
[[nodiscard]] Response handle(const Context& context, const Asker& asker,
                              const control::Request& request);

}  // namespace mlcca::requests
