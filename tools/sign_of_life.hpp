// SPDX-License-Identifier: BSD-2-Clause
// Standard input as a sign of life of the process that started this program.
#pragma once

namespace mlcca::tools {

/// Whether the end of `fd` can mean that the process which started us no longer needs us. False for
/// /dev/null, which says nothing, and for a terminal, where a person has Ctrl-C.
bool is_pipe(int fd);

/// Reads and drops what is available; false at the end of input.
bool discard_input(int fd);

}  // namespace mlcca::tools
