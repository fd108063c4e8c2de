// SPDX-License-Identifier: BSD-2-Clause
// Keeps in force what an earlier daemon has left, while this one starts: for a limited time, which
// is not extended by starts that do not finish.
#pragma once
#include <cstdint>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/mapped.hpp"

namespace mlcca::gates {

/// Gives heart-beats during a start, up to a limit of time that is noted in a pinned map.
class Starting {
 public:
  /// Notes in a map that is pinned at `control.directory()`/starting that a start has begun, unless
  /// one has begun and not finished. `limit`: ns from that begin in which gates are kept open.
  /// `now`: CLOCK_MONOTONIC, ns.
  static Result<Starting> begin(const Control& control, std::uint64_t limit, std::uint64_t now);

  /// Gives a heart-beat between two steps of the start, if the time lasts and the gates are open
  /// and have not lapsed. False if it gave none.
  bool beat(Control& control, std::uint64_t now);
  /// The gates hold what this daemon has decided: the next start gets its own time.
  void finish();

 private:
  Starting(Fd map, Mapped<std::uint64_t> began, std::uint64_t limit)
      : map_(std::move(map)), began_(std::move(began)), limit_(limit) {}
  Fd map_;
  Mapped<std::uint64_t> began_;  ///< 0: no start is under way
  std::uint64_t limit_;
};

}  // namespace mlcca::gates
