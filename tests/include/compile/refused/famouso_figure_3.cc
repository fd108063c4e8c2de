// SPDX-License-Identifier: BSD-2-Clause
// Figure 3 of the paper, letter for letter.
// expect: ATTRIBUTES_MISMATCH
// expect: Omission<5
// expect: Omission<2
// clang-format off
#include "Period.h"
#include "Omission.h"
#include "AttributeList.h"

// emergency switch event channel specification
struct EmergencySwitchSpec {
    typedef AttributeList<
        Period<50>,
        Omission<2>
       >::type attributes;
};

#include "CheckAttributeAgainstAttributeList.h"
// check within a network layer component
typedef CheckAttributeAgainstAttributeList<
    EmergencySwitchSpec::attributes,
    Omission<5>
   >::type test;
