// SPDX-License-Identifier: BSD-2-Clause
// Literals at their edges.
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;

static_assert(mlcca::count(18446744073_s) == 18446744073000000000U, "the largest whole second");
static_assert(mlcca::count(18446744073709551614_ns) == mlcca::kUnbounded - 1, "");
static_assert(mlcca::count(100_percent) == mlcca::kCertainLoss, "the largest loss");
static_assert(1'000'000_ns == 1_ms, "digits may be separated");
static_assert(mlcca::count(0_ms) == 0, "");
static_assert(
    mlcca::make_set<mlcca::Period<50_ms>, mlcca::Omission<2>>().has(mlcca::Attribute::omission),
    "");
