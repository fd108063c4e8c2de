// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO: a Deadline that is too late.
// expect: ATTRIBUTES_MISMATCH
// expect: Deadline<50
// expect: Deadline<30
#include "AttributeList.h"
#include "CheckAttributeAgainstAttributeList.h"
#include "Deadline.h"

using Required = AttributeList<Deadline<30>>;
typedef CheckAttributeAgainstAttributeList<Required, Deadline<50>>::type test;
