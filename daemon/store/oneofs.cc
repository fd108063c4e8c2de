// SPDX-License-Identifier: BSD-2-Clause
// The same as control/oneofs.cc, for the entries of the journal.
#include "daemon/store/messages.hpp"
// The generated code uses the messages above.
#include "daemon/store/oneofs.inc"
