// SPDX-License-Identifier: BSD-2-Clause
// Says what is wrong with a gateway and with granted deliveries, in lines for an operator.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/drop_watch.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {

/// The counters of a delivery's gates at the time when a frame was last seen to leave.
struct LatestLeft {
  std::uint64_t in = 0;
  std::uint64_t out = 0;
};

/// What one gate has counted for a granted delivery, at the network where its events enter or
/// leave.
struct Passage {
  std::string network;
  bool leaves = false;
  bool is_shared = false;  ///< the gate cannot distinguish the publisher from others of the channel
  Frames frames;           ///< since the slot was created
  /// Part of `frames`: those from before the latest change of the decision.
  std::uint64_t passed_before = 0;
  /// Frames of one event there that may come before the event is complete.
  std::uint64_t event_frames = 1;
  std::optional<LatestLeft> latest =
      {};                             ///< leaves: as of the latest poll; nullopt: not polled yet
  RecentDrops excess = {};            ///< frames in excess of the admitted traffic
  RecentDrops misfits = {};           ///< frames that name the subject but differ from the grant
  RecentDrops would_be_misfits = {};  ///< the same, but passed because of audit mode
  RecentDrops would_exceed = {};      ///< frames in excess, but passed because of audit mode
};

/// Everything that this gateway knows about a granted delivery.
struct Observed {
  std::optional<control::Watch> watch = {};
  /// Why nothing reports its silence; empty: it is reported, or no subscriber requires it.
  std::string not_supervised = {};
  std::vector<Passage> passages = {};
  std::string not_forwarded = {};  ///< why no rule of can-gw forwards it; empty: none has to
  std::string late = {};     ///< says that the forwarding program took too long; empty: it did not
  RecentDrops unknown = {};  ///< frames without a slot where its events enter
  std::string latest_unknown = {};  ///< the latest such frame: "123", "0x… from 10.0.0.7"
};

/// How long expected events have been missing, in ns; 0 if events come, come again, or are not
/// overdue.
[[nodiscard]] std::uint64_t silent_for(const control::Watch& watch);

/// What is wrong with a granted delivery, one line each; empty if nothing is wrong. Examples:
///   nothing has come for 4.2 s: 84 events are missing
///   12 frames on second-can in the last 40 s were more than was admitted
///   events come again, the latest 20 ms ago: not restored yet
///   not supervised: the gate cannot distinguish a and b
///   40 frames came in from second-can and none left to robot-can
///   40 frames came in from second-can since the latest left to robot-can: nothing forwards them
///   12 frames on second-can in the last 40 s named no known subject, the latest 124: does ...
///   the program that carries it to lan took up to 9.8 ms, longer than the gateway states, for ...
[[nodiscard]] std::vector<std::string> troubles(const Observed& seen);

/// The line which says that gates without pins may exist, because of the error `why`. The system
/// log has the complete error.
[[nodiscard]] std::string unlisted_gates(std::string_view why);

/// The health of a gateway whose gates are `open`. `lines` are the reasons. The first
/// control::Health::kMostReasons of them are reported, and the number of the others.
[[nodiscard]] control::Health health_of(bool open, std::vector<std::string> lines);

}  // namespace mlcca
