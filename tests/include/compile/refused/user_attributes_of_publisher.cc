// SPDX-License-Identifier: BSD-2-Clause
// The second attribute of the publisher does not fit, though the value of another one would.
// expect: ATTRIBUTES_MISMATCH
// expect: PROVIDED<
// expect: Wear<3
// expect: REQUIRED<
// expect: Wear<4
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::larger, mlcca::Composition::smallest> {};
using Publisher = mlcca::AttributeList<Temperature<280>, mlcca::Omission<2>, Wear<4>>;
using Subscriber = mlcca::AttributeList<Wear<2>, Temperature<281>>;
using Can = mlcca::AttributeList<Wear<3>, mlcca::Omission<1>, Temperature<270>>;
using check = mlcca::Check<mlcca::Union<Publisher, Subscriber>, Can>;
