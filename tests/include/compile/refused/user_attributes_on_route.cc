// SPDX-License-Identifier: BSD-2-Clause
// The second hop provides too little of one of two attributes.
// expect: ATTRIBUTES_MISMATCH
// expect: HOP<2
// expect: PROVIDED<
// expect: Wear<2
// expect: REQUIRED<
// expect: Wear<3
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::larger, mlcca::Composition::smallest> {};
using Publisher = mlcca::AttributeList<Temperature<280>, mlcca::Omission<2>>;
using Subscriber = mlcca::AttributeList<Temperature<290>, Wear<3>>;
using Can = mlcca::AttributeList<mlcca::Omission<0>, Temperature<270>, Wear<3>>;
using Mesh = mlcca::AttributeList<Wear<2>, mlcca::Omission<0>, Temperature<275>>;
using check = mlcca::CheckRoute<mlcca::Union<Publisher, Subscriber>,
                                mlcca::RouteOf<mlcca::Network<Can>, mlcca::Network<Mesh>>>;
