// SPDX-License-Identifier: BSD-2-Clause
// Each hop provides enough of both; the sum of one is too much.
// expect: ATTRIBUTES_MISMATCH
// expect: END_TO_END
// expect: PROVIDED<
// expect: Hops<4
// expect: REQUIRED<
// expect: Hops<3
#include "mlcca/static_check.hpp"

template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::larger, mlcca::Composition::smallest> {};
template <mlcca::Value V>
struct Hops : mlcca::UserAttribute<Hops, V, mlcca::Better::smaller, mlcca::Composition::sum> {};
using Publisher = mlcca::AttributeList<Wear<3>, Hops<4>>;
using Subscriber = mlcca::AttributeList<Hops<3>, Wear<2>>;
using Can = mlcca::AttributeList<Hops<2>, Wear<3>>;
using Mesh = mlcca::AttributeList<Wear<4>, Hops<2>>;
using check = mlcca::CheckRoute<mlcca::Union<Publisher, Subscriber>,
                                mlcca::RouteOf<mlcca::Network<Can>, mlcca::Network<Mesh>>>;
