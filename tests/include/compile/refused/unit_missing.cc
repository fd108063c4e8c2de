// SPDX-License-Identifier: BSD-2-Clause
// A bare number is no Period.
// expect: Nanoseconds
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;
mlcca::Period<50> period;
