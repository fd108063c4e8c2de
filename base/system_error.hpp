// SPDX-License-Identifier: BSD-2-Clause
// What the kernel refused, as an error in words.
#pragma once
#include <cerrno>
#include <cstring>
#include <expected>
#include <string>

#include "base/result.hpp"

namespace mlcca {

/// "WHAT: No such file or directory" of errno, or of `error`.
[[nodiscard]] inline std::unexpected<Error> system_error(const std::string& what,
                                                         int error = errno) {
  return fail(what + ": " + std::strerror(error));  // NOLINT(concurrency-mt-unsafe): one thread
}

}  // namespace mlcca
