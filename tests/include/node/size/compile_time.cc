// SPDX-License-Identifier: BSD-2-Clause
// The floor and a check at compile time, which must not add an octet.
#include "frame.hpp"
#include "mlcca/static_check.hpp"
#include "needs.hpp"

using SwitchOnItsBus = mlcca::Check<SwitchNeeds, OwnBus>::type;

void run() { outgoing = incoming; }
