// SPDX-License-Identifier: BSD-2-Clause
// Compares the measured load of a CAN bus with the analysed one. No I/O: counters and time come in
// as arguments.
#pragma once
#include <cstdint>
#include <optional>

#include "daemon/outside/frames.hpp"

namespace mlcca {

/// Measures the unaccounted load of one bus: measured load beyond what was analysed. All loads are
/// in 1e-6 of the bus time. Frames count with their fewest bits (11-bit identifier, no stuff bits),
/// so that stuff bits never count as unaccounted load.
class BusLoad {
 public:
  /// Loads are rounded up to multiples of this, in 1e-6, so that small differences cause no
  /// decision.
  static constexpr std::uint32_t kStep = 10'000;
  /// The number of measurements after which a lower load replaces a higher one.
  static constexpr int kHold = 5;

  /// To be called about once a second. `analysed` is the most that admitted messages and the
  /// declared background take. Returns the unaccounted load, rounded up to kStep: a higher value at
  /// once, a lower one after kHold measurements.
  std::uint32_t measure(const BusCounters& counters, std::uint32_t bitrate, std::uint64_t analysed,
                        std::uint64_t now_ns);

  /// The most that a load can be that was counted with the fewest bits: with 29-bit identifiers and
  /// all stuff bits.
  [[nodiscard]] static std::uint32_t at_most(std::uint32_t load);

  /// The measured load of the last interval, a lower bound.
  [[nodiscard]] std::uint64_t load() const { return load_; }

 private:
  std::optional<BusCounters> last_;
  std::uint64_t last_ns_ = 0;
  std::uint64_t load_ = 0;
  std::uint32_t excess_ = 0;
  int lower_for_ = 0;
};

/// Measures what one refused publisher sends on a CAN bus. The gate drops its frames, but they load
/// the bus on which they are sent.
class SenderLoad {
 public:
  /// To be called about once a second. `frames` is the count of its frames so far, with `bytes` of
  /// payload each. Returns the load in 1e-6 of the bus time, rounded up to BusLoad::kStep. A
  /// difference of one step is not a change.
  std::uint32_t measure(std::uint64_t frames, std::uint64_t bytes, std::uint32_t bitrate,
                        std::uint64_t now_ns);

 private:
  std::optional<std::uint64_t> last_;
  std::uint64_t last_ns_ = 0;
  std::uint32_t load_ = 0;
};

}  // namespace mlcca
