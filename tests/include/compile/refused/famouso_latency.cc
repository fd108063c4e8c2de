// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO: a Latency is held against the Deadline too, 31 ms against 30 ms.
// expect: ATTRIBUTES_MISMATCH
// expect: Latency<31000
// expect: Deadline<30
#include "AttributeList.h"
#include "CheckAttributeAgainstAttributeList.h"
#include "Deadline.h"
#include "Latency.h"

using Required = AttributeList<Deadline<30>>;
typedef CheckAttributeAgainstAttributeList<Required, Latency<31000>>::type test;
