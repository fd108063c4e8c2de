// SPDX-License-Identifier: BSD-2-Clause
// The crash tests of tests/daemon/store on the journal and on the prototype, counted: which answers
// are lost, which refused batches come back.
#pragma once
#include <string>

namespace mlcca::bench {

/// Prints a table. `directory`: for the real files of the process that is killed.
void crash_both(const std::string& directory);

}  // namespace mlcca::bench
