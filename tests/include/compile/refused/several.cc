// SPDX-License-Identifier: BSD-2-Clause
// Of several mismatches the first one in the order of the table.
// expect: ATTRIBUTES_MISMATCH
// expect: PROVIDED<
// expect: Latency<
// expect: 10000000
// expect: REQUIRED<
// expect: Latency<
// expect: 9000000
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Video = mlcca::AttributeList<mlcca::Bandwidth<400_kB_per_s>, mlcca::Latency<9_ms>>;
using Slow = mlcca::AttributeList<mlcca::Bandwidth<40_kB_per_s>, mlcca::Latency<10_ms>>;
using check = mlcca::Check<Video, Slow>;
