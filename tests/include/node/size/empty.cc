// SPDX-License-Identifier: BSD-2-Clause
// The floor: no check at all.
#include "frame.hpp"

void run() { outgoing = incoming; }
