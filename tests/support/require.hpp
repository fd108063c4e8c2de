// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdio>
#include <cstdlib>

namespace mlcca::test {

/// Ends the test program where the machine does not do what every test needs; errno says why.
inline void require(bool done, const char* what) {
  if (done) return;
  std::perror(what);
  std::abort();
}

}  // namespace mlcca::test
