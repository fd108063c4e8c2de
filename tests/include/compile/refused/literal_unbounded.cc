// SPDX-License-Identifier: BSD-2-Clause
// The value that stands for no bound.
// expect: NOT_A_WHOLE_DECIMAL_NUMBER_OR_TOO_LARGE_FOR_ITS_UNIT
// lines: 25
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;
mlcca::Period<18446744073709551615_ns> period;
