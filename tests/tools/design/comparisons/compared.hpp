// SPDX-License-Identifier: BSD-2-Clause
// Counts what instrumented objects compare (-fsanitize=fuzzer-no-link of clang): the same at each
// run, on every machine.
#pragma once
#include <cstdint>

namespace mlcca::test {

/// Comparisons of numbers so far, in all instrumented objects of this process.
[[nodiscard]] std::uint64_t compared();

}  // namespace mlcca::test
