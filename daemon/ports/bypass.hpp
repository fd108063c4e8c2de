// SPDX-License-Identifier: BSD-2-Clause
// Frames that a device has sent and its gate has not seen: AF_PACKET sockets with
// PACKET_QDISC_BYPASS skip every tc hook. Bookkeeping only: counters come in as arguments.
#pragma once
#include <cstdint>
#include <optional>

namespace mlcca {

class Bypass {
 public:
  /// Frames that may be between gate and counter, in the driver: no controller holds more.
  static constexpr std::uint64_t kInDriver = 64;

  struct Counts {
    std::uint64_t let_out_before = 0;  ///< by the gate, read before the others
    std::uint64_t waiting = 0;         ///< in the queue
    std::uint64_t sent = 0;            ///< by the device, and dropped behind the gate
    std::uint64_t let_out_after = 0;   ///< by the gate, read after the others
  };

  /// To be called about once a second. Frames that went past the gate and were not given back
  /// before; 0 up to kInDriver. The first call only remembers, as does one after a counter was set
  /// back. Frames that are lost in a driver without being counted hide as many that went past in
  /// the same interval.
  std::uint64_t update(const Counts& counts);
  /// The next call only remembers.
  void forget() { base_.reset(); }

 private:
  std::optional<std::int64_t> base_;  ///< least difference so far
  Counts last_;
};

}  // namespace mlcca
