// SPDX-License-Identifier: BSD-2-Clause
// More than all events lost.
// expect: NOT_A_WHOLE_DECIMAL_NUMBER_OR_TOO_LARGE_FOR_ITS_UNIT
// lines: 25
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;
mlcca::PacketLoss<101_percent> loss;
