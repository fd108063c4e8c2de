// SPDX-License-Identifier: BSD-2-Clause
// Results of measurements with probe frames and their assessment. Times are CLOCK_REALTIME in ns.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/can/wire.hpp"
#include "tools/doctor/device.hpp"
#include "tools/doctor/line.hpp"
#include "tools/doctor/probe.hpp"

namespace mlcca::doctor {

/// The time of frames on the bus may differ by this share from the time that their bits take.
inline constexpr double kTolerance = 0.02;
/// Without an echo for so long, in ms, none is expected any more.
inline constexpr unsigned kPatienceMs = 1000;

/// A frame that was sent while no other frame of ours was under way.
struct Single {
  std::uint64_t sent_ns = 0;
  bool refused = false;  ///< the queue had no room for it
  core::can::WireLength length;
  std::vector<std::uint64_t> echoes_ns;
};

/// Frames sent back to back: everything that passed after the first echo, up to the last one.
struct Passage {
  unsigned sent = 0;
  unsigned echoed = 0;
  unsigned foreign = 0;  ///< frames of other nodes among them
  unsigned errors = 0;   ///< error frames
  core::can::WireLength length = {};
  std::uint64_t took_ns = 0;
};

/// Computes a Passage from the frames that are sent and seen, in order of their times.
class PassageCount {
 public:
  void take_sent() { ++passage_.sent; }
  void take_seen(const Seen& seen);
  [[nodiscard]] const Passage& passage() const { return passage_; }

 private:
  Passage passage_;
  std::optional<std::uint64_t> first_ns_;
  /// The frames of others after our latest echo; they count only if another echo follows.
  core::can::WireLength since_own_;
  unsigned foreign_since_own_ = 0;
};

/// Frames sent until the queue had no room.
struct Filling {
  unsigned taken = 0;
  unsigned left = 0;     ///< number of them that were on the bus when the queue was full
  unsigned echoed = 0;   ///< number of echoes in the end
  bool refused = false;  ///< the queue became full
};

/// When a bus-off was seen; a time that was not seen is nullopt.
struct BusOff {
  std::optional<std::uint64_t> frame_ns;      ///< an error frame reported bus-off
  std::optional<std::uint64_t> link_ns;       ///< rtnetlink reported bus-off
  std::optional<std::uint64_t> recovered_ns;  ///< rtnetlink reported another state afterwards
  unsigned seconds = 0;                       ///< how long each of the two was waited for
};

[[nodiscard]] Line judge_echo(const Device& device, std::span<const Single> singles);
/// `data`: the passage is of FD frames, and their data phase is assessed.
[[nodiscard]] Line judge_rate(const Device& device, const Passage& passage, bool data);
/// `described` is the fifo-depth of the port in the description, if known.
[[nodiscard]] Line judge_depth(const Device& device, std::span<const Filling> fillings,
                               std::optional<unsigned> described);
[[nodiscard]] Line judge_bus_off(const BusOff& seen);
[[nodiscard]] Line judge_counters(const std::optional<net::ErrorCounters>& before,
                                  const std::optional<net::ErrorCounters>& after);

/// Why the echoes of this device say nothing about the bit rate of its bus; nullopt if they do.
[[nodiscard]] std::optional<std::string> why_no_rate(const Device& device, bool data);
/// Why the depth of its queue cannot be measured; nullopt if it can.
[[nodiscard]] std::optional<std::string> why_no_depth(const Device& device);

}  // namespace mlcca::doctor
