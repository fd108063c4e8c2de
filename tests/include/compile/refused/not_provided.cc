// SPDX-License-Identifier: BSD-2-Clause
// What a network does not state it does not provide.
// expect: ATTRIBUTES_MISMATCH
// expect: NOT_PROVIDED
// expect: REQUIRED<
// expect: Bandwidth<
// expect: 400000
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Video = mlcca::AttributeList<mlcca::Bandwidth<400_kB_per_s>>;
using Can = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<1>>;
using check = mlcca::Check<Video, Can>;
