// SPDX-License-Identifier: BSD-2-Clause
// Detects frames that a device has sent without its gate: AF_PACKET sockets with
// PACKET_QDISC_BYPASS skip every tc hook. Bookkeeping only: counters are arguments.
#pragma once
#include <cstdint>
#include <optional>

namespace mlcca {

/// Compares what the gate has let out with what the device has sent.
class Bypass {
 public:
  /// The most frames that may be between gate and counter, in the driver; no controller holds more.
  static constexpr std::uint64_t kInDriver = 64;

  struct Counts {
    std::uint64_t let_out_before = 0;  ///< by the gate; read before the others
    std::uint64_t waiting = 0;         ///< in the queue
    std::uint64_t sent = 0;            ///< by the device, and dropped after the gate
    std::uint64_t let_out_after = 0;   ///< by the gate; read after the others
  };

  /// To be called about once a second. Returns the frames that bypassed the gate and were not
  /// returned before; 0 if they are at most kInDriver. The first call returns 0, and so does one
  /// after a counter was reset. Frames that a driver loses without counting hide as many that
  /// bypassed the gate in the same interval.
  std::uint64_t update(const Counts& counts);
  /// The next call starts again, and returns 0.
  void forget() { base_.reset(); }

 private:
  std::optional<std::int64_t> base_;  ///< the least difference so far
  Counts last_;
};

}  // namespace mlcca
