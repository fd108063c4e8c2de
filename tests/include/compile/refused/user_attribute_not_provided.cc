// SPDX-License-Identifier: BSD-2-Clause
// An attribute of the user's own that the network does not know.
// expect: ATTRIBUTES_MISMATCH
// expect: NOT_PROVIDED
// expect: REQUIRED<
// expect: Temperature<280
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Can = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<1>>;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
using check = mlcca::Check<mlcca::AttributeList<Temperature<280>>, Can>;
