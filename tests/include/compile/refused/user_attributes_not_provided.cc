// SPDX-License-Identifier: BSD-2-Clause
// The network provides one attribute of the user's own and not the other.
// expect: ATTRIBUTES_MISMATCH
// expect: NOT_PROVIDED
// expect: REQUIRED<
// expect: Wear<0
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::larger, mlcca::Composition::smallest> {};
using Can = mlcca::AttributeList<mlcca::Omission<1>, Temperature<270>>;
using check = mlcca::Check<mlcca::AttributeList<Temperature<280>, Wear<0>>, Can>;
