// SPDX-License-Identifier: BSD-2-Clause
// What is wrong with a gateway and with what it has granted, in lines that an operator reads.
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

/// What the gates of a delivery had passed when a frame was last seen to leave.
struct LatestLeft {
  std::uint64_t in = 0;
  std::uint64_t out = 0;
};

/// What one gate has seen of a granted delivery, at the network where its events come in or leave.
struct Passage {
  std::string network;
  bool leaves = false;
  bool is_shared = false;                 ///< with other publishers of the channel that cannot be
                                          ///< distinguished
  Frames frames;                          ///< since the slot was made
  std::uint64_t passed_before = 0;        ///< of them, when the channel was last decided otherwise
  std::uint64_t event_frames = 1;         ///< that an event may have there, before it is whole
  std::optional<LatestLeft> latest = {};  ///< leaves: at the latest poll; nothing: not polled yet
  RecentDrops excess = {};                ///< more than was admitted
  RecentDrops misfits = {};               ///< named the subject and differed from the grant
  RecentDrops would_be_misfits = {};      ///< the same, let through by audit mode
  RecentDrops would_exceed = {};          ///< more than was admitted, let through by audit mode
};

/// Everything that this gateway knows of a granted delivery.
struct Observed {
  std::optional<control::Watch> watch = {};
  std::string not_supervised = {};  ///< why nothing reports its silence; empty: it is reported, or
                                    ///< no subscriber minds
  std::vector<Passage> passages = {};
  std::string not_forwarded = {};   ///< why no rule of can-gw carries it; empty: none has to
  std::string late = {};            ///< that the program that carries it took too long; empty: no
  RecentDrops unknown = {};         ///< frames without a slot where its events come in
  std::string latest_unknown = {};  ///< the latest of them: "123", "0x… from 10.0.0.7"
};

/// For so long nothing has come that should have, ns; 0: events come, come again, or may come yet.
[[nodiscard]] std::uint64_t silent_for(const control::Watch& watch);

/// What is wrong with it, one line each; nothing where all is as granted:
///   nothing has come for 4.2 s: 84 events are missing
///   12 frames on second-can in the last 40 s were more than was admitted
///   events come again, the latest 20 ms ago: not restored yet
///   not supervised: a and b look alike to the gate
///   40 frames came in from second-can and none left to robot-can
///   40 frames came in from second-can since the latest left to robot-can: nothing forwards them
///   12 frames on second-can in the last 40 s named no known subject, the latest 124: does ...
///   the program that carries it to lan took up to 9.8 ms, longer than the gateway states, for ...
[[nodiscard]] std::vector<std::string> troubles(const Observed& seen);

/// That gates without pins may be left, because of `why`, an error that the system log has whole.
[[nodiscard]] std::string unlisted_gates(std::string_view why);

/// `lines` are the reasons of a gateway whose gates are `open`; of them the first
/// control::Health::kMostReasons are reported, and how many were left out.
[[nodiscard]] control::Health health_of(bool open, std::vector<std::string> lines);

}  // namespace mlcca
