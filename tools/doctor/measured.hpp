// SPDX-License-Identifier: BSD-2-Clause
// What was measured with probe frames, and what to think of it. Times are CLOCK_REALTIME in ns.
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

/// A time that frames take on the bus may differ so much from what their bits take.
inline constexpr double kTolerance = 0.02;
/// No echo for so long: nothing comes any more.
inline constexpr unsigned kPatienceMs = 1000;

/// One frame, sent while nothing else of ours was under way.
struct Single {
  std::uint64_t sent_ns = 0;
  bool refused = false;  ///< there was no room for it
  core::can::WireLength length;
  std::vector<std::uint64_t> echoes_ns;
};

/// Frames back to back: all that passed behind the first echo of ours, up to the last one.
struct Passage {
  unsigned sent = 0;
  unsigned echoed = 0;
  unsigned foreign = 0;  ///< frames of others among them
  unsigned errors = 0;   ///< error frames
  core::can::WireLength length = {};
  std::uint64_t took_ns = 0;
};

/// Makes one of what is sent and seen, in the order of its times.
class PassageCount {
 public:
  void take_sent() { ++passage_.sent; }
  void take_seen(const Seen& seen);
  [[nodiscard]] const Passage& passage() const { return passage_; }

 private:
  Passage passage_;
  std::optional<std::uint64_t> first_ns_;
  /// What others sent behind our last frame counts only when one of ours follows.
  core::can::WireLength since_own_;
  unsigned foreign_since_own_ = 0;
};

/// As many frames as are taken until there is no room.
struct Filling {
  unsigned taken = 0;
  unsigned left = 0;     ///< of these on the bus when there was no more room
  unsigned echoed = 0;   ///< in the end
  bool refused = false;  ///< there was an end
};

struct BusOff {
  std::optional<std::uint64_t> frame_ns;      ///< an error frame said bus-off
  std::optional<std::uint64_t> link_ns;       ///< rtnetlink said bus-off
  std::optional<std::uint64_t> recovered_ns;  ///< rtnetlink says another state
  unsigned seconds = 0;                       ///< waited for each of both
};

[[nodiscard]] Line judge_echo(const Device& device, std::span<const Single> singles);
/// `data`: of FD frames, whose data phase is meant.
[[nodiscard]] Line judge_rate(const Device& device, const Passage& passage, bool data);
/// `described`: fifo-depth of the port in the description, where it is known.
[[nodiscard]] Line judge_depth(const Device& device, std::span<const Filling> fillings,
                               std::optional<unsigned> described);
[[nodiscard]] Line judge_bus_off(const BusOff& seen);
[[nodiscard]] Line judge_counters(const std::optional<net::ErrorCounters>& before,
                                  const std::optional<net::ErrorCounters>& after);

/// Why the echoes of this device say nothing about the time on its bus; nothing: they do.
[[nodiscard]] std::optional<std::string> why_no_rate(const Device& device, bool data);
/// Why frames cannot be counted into its queue.
[[nodiscard]] std::optional<std::string> why_no_depth(const Device& device);

}  // namespace mlcca::doctor
