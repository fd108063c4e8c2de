// SPDX-License-Identifier: BSD-2-Clause
// Bytes are no Period.
// expect: Nanoseconds
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;
mlcca::Period<50_bytes> period;
