// SPDX-License-Identifier: BSD-2-Clause
// A Period without a Deadline implies one, and a Latency is held against it.
// expect: ATTRIBUTES_MISMATCH
// expect: PROVIDED<
// expect: Latency<
// expect: 60000000
// expect: REQUIRED<
// expect: Period<
// expect: 50000000
// expect: AS_DEADLINE
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Late = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Latency<60_ms>, mlcca::Omission<1>>;
using check = mlcca::Check<Switch, Late>;
