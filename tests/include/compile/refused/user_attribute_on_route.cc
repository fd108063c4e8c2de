// SPDX-License-Identifier: BSD-2-Clause
// An attribute of the user's own on a route.
// expect: ATTRIBUTES_MISMATCH
// expect: HOP<2
// expect: Temperature<300
// expect: Temperature<280
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
using Route = mlcca::RouteOf<mlcca::Network<mlcca::AttributeList<Temperature<270>>>,
                             mlcca::Network<mlcca::AttributeList<Temperature<300>>>>;
using check = mlcca::CheckRoute<mlcca::AttributeList<Temperature<280>>, Route>;
