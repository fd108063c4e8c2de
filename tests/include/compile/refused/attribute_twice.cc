// SPDX-License-Identifier: BSD-2-Clause
// An attribute twice.
// expect: static
// expect: an attribute is given twice in one AttributeList
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>, mlcca::Period<60_ms>> list;
