// SPDX-License-Identifier: BSD-2-Clause
// More hops than can be composed.
// expect: static
// expect: a route has 1 to 16 hops
// lines: 20
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Can = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<1>>;
using Hop = mlcca::Network<Can>;
using Route = mlcca::RouteOf<Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop, Hop,
                             Hop, Hop, Hop>;
using check = mlcca::CheckRoute<Switch, Route>;
