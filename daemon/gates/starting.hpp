// SPDX-License-Identifier: BSD-2-Clause
// Keeps in force what the daemon before this one has left, while this one starts: for a stated
// time, which goes on over starts that were not finished.
#pragma once
#include <cstdint>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/mapped.hpp"

namespace mlcca::enforce {

class Starting {
 public:
  /// Notes in a map that is pinned beside the control word, `control.directory()`/starting, that a
  /// start has begun, unless one has begun that was not finished. `limit`: ns from that on in which
  /// gates are kept. `now`: CLOCK_MONOTONIC, ns.
  static Result<Starting> begin(const Control& control, std::uint64_t limit, std::uint64_t now);

  /// A heart-beat between two steps of the start, while the time lasts and the gates are open and
  /// have not lapsed. False: there was none.
  bool beat(Control& control, std::uint64_t now);
  /// The gates hold what this daemon has decided: whoever comes next starts over.
  void finish();

 private:
  Starting(Fd map, Mapped<std::uint64_t> began, std::uint64_t limit)
      : map_(std::move(map)), began_(std::move(began)), limit_(limit) {}
  Fd map_;
  Mapped<std::uint64_t> began_;  ///< 0: no start is under way
  std::uint64_t limit_;
};

}  // namespace mlcca::enforce
