// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/design/comparisons/compared.hpp"

namespace {
std::uint64_t count = 0;
}  // namespace

// What the compiler calls: see its documentation of SanitizerCoverage.
// NOLINTBEGIN(*-reserved-identifier)
extern "C" {
void __sanitizer_cov_trace_cmp1(std::uint8_t, std::uint8_t) { ++count; }
void __sanitizer_cov_trace_cmp2(std::uint16_t, std::uint16_t) { ++count; }
void __sanitizer_cov_trace_cmp4(std::uint32_t, std::uint32_t) { ++count; }
void __sanitizer_cov_trace_cmp8(std::uint64_t, std::uint64_t) { ++count; }
void __sanitizer_cov_trace_const_cmp1(std::uint8_t, std::uint8_t) { ++count; }
void __sanitizer_cov_trace_const_cmp2(std::uint16_t, std::uint16_t) { ++count; }
void __sanitizer_cov_trace_const_cmp4(std::uint32_t, std::uint32_t) { ++count; }
void __sanitizer_cov_trace_const_cmp8(std::uint64_t, std::uint64_t) { ++count; }
}
// NOLINTEND(*-reserved-identifier)

std::uint64_t mlcca::test::compared() { return count; }
