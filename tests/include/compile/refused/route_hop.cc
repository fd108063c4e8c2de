// SPDX-License-Identifier: BSD-2-Clause
// One hop of the route is not good enough.
// expect: ATTRIBUTES_MISMATCH
// expect: HOP<3
// expect: Omission<5
// expect: Omission<2
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Can = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<1>>;
using Bridge = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<5>>;
using Pc = mlcca::AttributeList<mlcca::Latency<1_ms>, mlcca::Omission<0>>;
using Route = mlcca::RouteOf<mlcca::Network<Can>, mlcca::Gateway<Pc>, mlcca::Network<Bridge>>;
using check = mlcca::CheckRoute<Switch, Route>;
