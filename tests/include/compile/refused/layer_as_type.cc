// SPDX-License-Identifier: BSD-2-Clause
// The same, with the ::type that FAMOUSO is used to.
// expect: ATTRIBUTES_MISMATCH
// expect: Omission<5
// expect: Omission<2
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Bridge = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<5>>;
using check = mlcca::Check<Switch, Bridge>::type;
