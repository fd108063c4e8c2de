// SPDX-License-Identifier: BSD-2-Clause
// Times and bytes have no sum.
// expect: Nanoseconds
// lines: 20
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;
constexpr auto kSum = 50_ms + 50_bytes;
