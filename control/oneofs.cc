// SPDX-License-Identifier: BSD-2-Clause
// The functions that copy, move and destroy a Request or a Reply. They are instantiated here once;
// instantiating them in each file took a third of its compile time.
#include "control/messages.hpp"
// This must follow the header, whose declarations it uses.
#include "control/oneofs.inc"
