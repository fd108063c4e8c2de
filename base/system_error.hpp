// SPDX-License-Identifier: BSD-2-Clause
// Makes an Error of the code that a system call left in errno.
#pragma once
#include <cerrno>
#include <cstring>
#include <expected>
#include <string>

#include "base/result.hpp"

namespace mlcca {

/// "WHAT: No such file or directory"; `error` is an errno value.
[[nodiscard]] inline std::string error_words(const std::string& what, int error) {
  return what + ": " + std::strerror(error);  // NOLINT(concurrency-mt-unsafe): one thread
}

/// An Error with these words; `error` is an errno value.
[[nodiscard]] inline std::unexpected<Error> system_error(const std::string& what,
                                                         int error = errno) {
  return fail(error_words(what, error));
}

}  // namespace mlcca
