// SPDX-License-Identifier: BSD-2-Clause
// Standard input as the sign of life of whoever started a program.
#pragma once

namespace mlcca::tools {

/// Its end can say that whoever started us does not need us any more. /dev/null says nothing, and a
/// terminal has Ctrl-C.
bool is_pipe(int fd);

/// Reads what is there; false at the end.
bool discard_input(int fd);

}  // namespace mlcca::tools
