// SPDX-License-Identifier: BSD-2-Clause
// A publisher that sends too seldom.
// expect: ATTRIBUTES_MISMATCH
// expect: PUBLISHED<
// expect: Period<
// expect: 50000000
// expect: REQUIRED<
// expect: Period<
// expect: 40000000
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Motor = mlcca::AttributeList<mlcca::Period<40_ms>>;
using check = mlcca::CheckTraffic<Switch, Motor>;
