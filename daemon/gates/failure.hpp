// SPDX-License-Identifier: BSD-2-Clause
// Turns an errno into an Error.
#pragma once
#include <cstdlib>
#include <cstring>
#include <string>

#include "base/result.hpp"

namespace mlcca::gates {

/// "CALL: No such device"; `error` is a negative or positive errno.
inline std::unexpected<Error> failure(const std::string& call, int error) {
  return fail(call + ": " + std::strerror(std::abs(error)));
}

}  // namespace mlcca::gates
