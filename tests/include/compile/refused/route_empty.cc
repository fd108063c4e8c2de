// SPDX-License-Identifier: BSD-2-Clause
// No route.
// expect: static
// expect: a route has 1 to 16 hops
// lines: 20
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using check = mlcca::CheckRoute<Switch, mlcca::RouteOf<>>;
