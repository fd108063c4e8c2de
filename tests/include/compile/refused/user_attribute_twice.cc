// SPDX-License-Identifier: BSD-2-Clause
// An attribute of the user's own twice.
// expect: static
// expect: an attribute is given twice in one AttributeList
// lines: 25
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
using Twice = mlcca::AttributeList<Temperature<280>, Temperature<290>>;
using check = mlcca::Check<Twice, mlcca::AttributeList<Temperature<270>>>;
