// SPDX-License-Identifier: BSD-2-Clause
// A publisher that sends more than the subscriber takes.
// expect: ATTRIBUTES_MISMATCH
// expect: PUBLISHED<
// expect: MaxPayload<
// expect: 9
// expect: ACCEPTED<
// expect: MaxPayload<
// expect: 8
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using check = mlcca::CheckTraffic<mlcca::AttributeList<mlcca::MaxPayload<9_bytes>>,
                                  mlcca::AttributeList<mlcca::MaxPayload<8_bytes>>>;
