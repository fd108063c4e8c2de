// SPDX-License-Identifier: BSD-2-Clause
// What copies, moves and destroys a Request or a Reply: it would be instantiated in each file that
// has one, which took a third of the time of compiling it.
#include "control/messages.hpp"
// After that.
#include "control/oneofs.inc"
