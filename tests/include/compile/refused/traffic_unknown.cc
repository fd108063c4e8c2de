// SPDX-License-Identifier: BSD-2-Clause
// What a publisher does not state is unknown.
// expect: ATTRIBUTES_MISMATCH
// expect: NOT_PUBLISHED
// expect: REQUIRED<
// expect: Jitter<
// expect: 1000000
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using check = mlcca::CheckTraffic<Switch, mlcca::AttributeList<mlcca::Jitter<1_ms>>>;
