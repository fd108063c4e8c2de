// SPDX-License-Identifier: BSD-2-Clause
// A best case refutes.
// expect: ATTRIBUTES_MISMATCH
// expect: PROVIDED<
// expect: Dynamic<
// expect: Latency<
// expect: 5000000
// expect: REQUIRED<
// expect: Latency<
// expect: 4000000
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Fast = mlcca::AttributeList<mlcca::Latency<4_ms>>;
using Mesh = mlcca::AttributeList<mlcca::Dynamic<mlcca::Latency<5_ms>>>;
using check = mlcca::Check<Fast, Mesh>;
