// SPDX-License-Identifier: BSD-2-Clause
// Reports that something is lost, and that it is back, once each.
#pragma once
#include <cstdint>
#include <utility>

namespace mlcca {

/// Decides when the loss of a service is reported, and its return: once each, however often its
/// reason changes meanwhile. Reports of a loss are at least kQuiet apart: one that begins earlier
/// is reported if it lasts until then. Times are in ns.
class Outage {
 public:
  static constexpr std::uint64_t kQuiet = 10'000'000'000;
  enum class Report : std::uint8_t { none, lost, back };

  /// Takes the result of a check at `now`, and returns what is to be reported.
  [[nodiscard]] Report take(bool lost, std::uint64_t now) {
    if (!lost) {
      if (std::exchange(lost_, false) && !reported_) ++unreported_;
      return std::exchange(reported_, false) ? Report::back : Report::none;
    }
    lost_ = true;
    if (reported_ || now < quiet_until_) return Report::none;
    reported_ = true;
    quiet_until_ = now + kQuiet;
    return Report::lost;
  }
  /// How many losses were over before they could be reported, since this was last asked.
  [[nodiscard]] unsigned take_unreported() { return std::exchange(unreported_, 0); }

 private:
  bool lost_ = false;
  bool reported_ = false;
  unsigned unreported_ = 0;
  std::uint64_t quiet_until_ = 0;
};

}  // namespace mlcca
