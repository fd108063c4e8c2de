// SPDX-License-Identifier: BSD-2-Clause
// What is really sent on a CAN bus, against what was analysed. Bookkeeping only: counters and time
// come in as arguments.
#pragma once
#include <cstdint>
#include <optional>

#include "daemon/outside/frames.hpp"

namespace mlcca {

class BusLoad {
 public:
  /// Differences that count are whole steps of the bus time: 1e-6.
  static constexpr std::uint32_t kStep = 10'000;
  /// A load that went down counts after so many measurements.
  static constexpr int kHold = 5;

  /// To be called about once a second. `analysed`: 1e-6 of the bus time that admitted messages and
  /// declared background take at most. Gives the unaccounted load, which the bus carried in excess
  /// of that, in 1e-6, rounded up to steps: more at once, less once it has lasted. Frames count
  /// with their fewest bits (11-bit identifier, nothing stuffed), so that stuff bits never count as
  /// unaccounted load.
  std::uint32_t measure(const BusCounters& counters, std::uint32_t bitrate, std::uint64_t analysed,
                        std::uint64_t now_ns);

  /// What a load that was counted with the fewest bits takes at most: with 29-bit identifiers and
  /// all stuff bits.
  [[nodiscard]] static std::uint32_t at_most(std::uint32_t load);

  /// 1e-6 of the bus time that was carried at least, in the last interval.
  [[nodiscard]] std::uint64_t load() const { return load_; }

 private:
  std::optional<BusCounters> last_;
  std::uint64_t last_ns_ = 0;
  std::uint64_t load_ = 0;
  std::uint32_t excess_ = 0;
  int lower_for_ = 0;
};

/// What one publisher sends on a CAN bus that is not granted: it is dropped, and on its own bus all
/// the same.
class SenderLoad {
 public:
  /// To be called about once a second. `frames`: of it so far, of `bytes` each. 1e-6 of the bus
  /// time, rounded up to steps; a step more or less is no change.
  std::uint32_t measure(std::uint64_t frames, std::uint64_t bytes, std::uint32_t bitrate,
                        std::uint64_t now_ns);

 private:
  std::optional<std::uint64_t> last_;
  std::uint64_t last_ns_ = 0;
  std::uint32_t load_ = 0;
};

}  // namespace mlcca
