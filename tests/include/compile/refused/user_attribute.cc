// SPDX-License-Identifier: BSD-2-Clause
// An attribute of the user's own.
// expect: ATTRIBUTES_MISMATCH
// expect: PROVIDED<
// expect: Temperature<300
// expect: REQUIRED<
// expect: Temperature<280
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
using check =
    mlcca::Check<mlcca::AttributeList<Temperature<280>>, mlcca::AttributeList<Temperature<300>>>;
