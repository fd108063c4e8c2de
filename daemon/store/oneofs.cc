// SPDX-License-Identifier: BSD-2-Clause
// As control/oneofs.cc, of the entries of the journal.
#include "daemon/store/messages.hpp"
// After that.
#include "daemon/store/oneofs.inc"
