// SPDX-License-Identifier: BSD-2-Clause
// The same as control/oneofs.cc, for the entries of the journal.
#include "daemon/store/messages.hpp"
// After that.
#include "daemon/store/oneofs.inc"
