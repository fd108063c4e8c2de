// SPDX-License-Identifier: BSD-2-Clause
// Each hop is good enough, all together are not: (1 + 1)(1 + 1) - 1 events in a row.
// expect: ATTRIBUTES_MISMATCH
// expect: END_TO_END
// expect: Omission<3
// expect: Omission<2
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Can = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<1>>;
using Pc = mlcca::AttributeList<mlcca::Latency<1_ms>, mlcca::Omission<0>>;
using Route = mlcca::RouteOf<mlcca::Network<Can>, mlcca::Gateway<Pc>, mlcca::Network<Can>>;
using check = mlcca::CheckRoute<Switch, Route>;
