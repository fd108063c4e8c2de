// SPDX-License-Identifier: BSD-2-Clause
// No attribute is negative. A compiler that says so may go on to say that it is too large.
// expect: mission
// errors: 2
// lines: 15
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;
mlcca::Omission<-1> omission;
