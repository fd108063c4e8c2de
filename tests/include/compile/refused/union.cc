// SPDX-License-Identifier: BSD-2-Clause
// Publisher and subscriber ask together.
// expect: ATTRIBUTES_MISMATCH
// expect: Omission<5
// expect: Omission<2
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Logger = mlcca::AttributeList<mlcca::Omission<9>>;
using Bridge = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<5>>;
using check = mlcca::Check<mlcca::Union<Switch, Logger>, Bridge>;
