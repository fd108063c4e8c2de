// SPDX-License-Identifier: BSD-2-Clause
// Only the last attribute of the subscriber does not fit.
// expect: ATTRIBUTES_MISMATCH
// expect: PROVIDED<
// expect: Temperature<270
// expect: REQUIRED<
// expect: Temperature<269
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::larger, mlcca::Composition::smallest> {};
using Publisher = mlcca::AttributeList<Temperature<280>, Wear<3>>;
using Subscriber = mlcca::AttributeList<Wear<2>, mlcca::Omission<2>, Temperature<269>>;
using Can = mlcca::AttributeList<Wear<3>, mlcca::Omission<1>, Temperature<270>>;
using check = mlcca::Check<mlcca::Union<Publisher, Subscriber>, Can>;
