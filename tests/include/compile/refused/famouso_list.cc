// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO: a list in place of the attribute must provide everything.
// expect: ATTRIBUTES_MISMATCH
// expect: NOT_PROVIDED
// expect: Omission<2
#include "AttributeList.h"
#include "CheckAttributeAgainstAttributeList.h"
#include "Latency.h"
#include "Omission.h"

using Required = AttributeList<Latency<100>, Omission<2>>;
using Layer = AttributeList<Latency<90>>;
typedef CheckAttributeAgainstAttributeList<Required, Layer>::type test;
