// SPDX-License-Identifier: BSD-2-Clause
// Derives from the verdicts what the gates of one gateway must hold, and the changes from one such
// state to the next.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/gates/direction.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {

/// Identifies what one slot of a gate admits or refuses: exactly what was granted. Where frames
/// carry the subject, id and mask are 0.
struct GateEntry {
  std::size_t port = 0;  ///< index among the gateway's ports
  Direction direction = Direction::ingress;
  std::uint32_t id = 0;  ///< a frame matches if (can_id & mask) == id
  std::uint32_t mask = 0;
  std::optional<std::size_t>
      source_port;  ///< egress: port at which the frame arrived; nullopt: from a local program
  FrameIdentity entered_as;  ///< egress, from another bus: the identity with which it was admitted
                             ///< there
  std::uint32_t uid = 0;     ///< egress, from a local program: its user ID
  bool from_kernel = false;  ///< egress: sent by a protocol in the kernel, not by a program
  Station station;  ///< Ethernet: sender of the frame; the wildcard stands for all without an entry
                    ///< of their own
  std::uint16_t max_length = 0;  ///< payload bytes of a frame or datagram; of a transported
                                 ///< message, of the message
  bool classic = false;
  bool fd = false;
  bool xl = false;
  bool fragmented = false;  ///< Ethernet: datagrams may hold a fragment of an event
  bool transport = false;   ///< CAN: longer events are carried by transport_of()
  Subject subject = 0;

  /// Payload bytes of one frame or datagram.
  [[nodiscard]] std::uint16_t frame_length() const { return transport ? 8 : max_length; }
  auto operator<=>(const GateEntry&) const = default;
};

/// The admitted traffic of an entry, as parameters of the generic cell rate algorithm (GCRA; ITU-T
/// I.371, virtual scheduling). A frame costs per_frame + bytes * per_byte and may arrive
/// `tolerance` early. If neither cost is set, the entry is not policed.
struct Policing {
  Value per_frame = 0;       ///< ns per frame
  Value per_byte = 0;        ///< 2^-8 ns per payload byte
  Value tolerance = 0;       ///< ns that a frame may be early
  bool counts_only = false;  ///< excess is counted and passes
  bool operator==(const Policing&) const = default;
  [[nodiscard]] bool any() const { return per_frame != 0 || per_byte != 0; }
};

/// How the events of an entry are supervised. Without a period there is no silence timer; sporadic
/// events have none.
struct Watching {
  Value period = 0;    ///< ns between events, as the publisher states it
  Value silence = 0;   ///< ns without an event after which events are missing; 0: no subscriber
                       ///< requires it
  Value together = 0;  ///< ns: frames that follow the first one of an event within this time belong
                       ///< to it
  bool operator==(const Watching&) const = default;
};

/// An entry with its verdict, policing and supervision.
struct GateRule {
  GateEntry entry;
  bool pass = false;
  Policing policing;
  Watching watching;
  bool operator==(const GateRule&) const = default;
};

/// The rules of all gates of one gateway, sorted by entry; each entry occurs once. If two
/// publishers cannot be distinguished on the wire, their frames pass only if both may pass.
using GateState = std::vector<GateRule>;

/// The steps from one state to the next. Frames see either all of them or none (ADR 20).
struct GateChanges {
  std::vector<GateEntry> close;
  std::vector<GateEntry> remove;
  std::vector<GateRule> add;  ///< denied first, then opened with the others if they pass
  std::vector<GateEntry> open;
  std::vector<GateRule> police;  ///< entries that stay, with their new policing and supervision
  [[nodiscard]] bool empty() const {
    return close.empty() && remove.empty() && add.empty() && open.empty() && police.empty();
  }
  bool operator==(const GateChanges&) const = default;
};
/// The changes that lead from `now` to `next`.
[[nodiscard]] GateChanges gate_changes_between(const GateState& now, const GateState& next);

/// The traffic specification of a publisher with these attributes, as policing of frames. `frames`:
/// frames per event. It admits one event per Period, or Bandwidth bytes/s in events of MaxPayload
/// (`largest` if not stated), plus 500 ppm for differing clocks, and an event and its Jitter early.
/// Without Period and Bandwidth nothing is policed.
[[nodiscard]] Policing policing_of(const AttributeSet& offered, std::uint64_t frames,
                                   Value largest = 1);

/// The time (ns) without an event at a gate after which more events are missing than the delivery
/// allows: (Omission + 1) * Period + Jitter plus 500 ppm for differing clocks, that is the
/// worst-case reaction without the Latency. 0 if it is unknown, nothing was granted, or the events
/// are sporadic.
[[nodiscard]] Value silence_of(const Verdict& verdict);

/// The same for a delivery from program to program on one gateway. There is no network in between,
/// so a Jitter that is not stated counts as 0.
[[nodiscard]] Value silence_here(const Verdict& verdict);

/// Whether a granted delivery goes another way than over the gateway that has these rules for it:
/// the publisher is known there, and its frames do not pass.
[[nodiscard]] bool goes_elsewhere(const Verdict& verdict, const GateState& rules);

/// Granted events of a publisher at one gateway: the entries by which their frames arrive and
/// leave.
struct Passage {
  std::size_t publisher = 0;
  std::size_t set = 0;             ///< the attribute set in use
  std::optional<GateEntry> in{};   ///< nullopt: the publisher is a local program
  std::optional<GateEntry> out{};  ///< nullopt: a subscriber is a local program
  bool by_kernel = false;          ///< the kernel carries them from port to port, not a program
  auto operator<=>(const Passage&) const = default;
};
/// The passages of one channel, sorted and without duplicates.
[[nodiscard]] std::vector<Passage> passages(const System& system, const Members& members,
                                            std::size_t channel,
                                            const std::vector<Verdict>& verdicts,
                                            std::size_t gateway);

/// A passage that the kernel carries from one bus to another.
struct Transit {
  GateEntry in;
  GateEntry out;
  auto operator<=>(const Transit&) const = default;
};
/// The transits of one channel, sorted and without duplicates.
[[nodiscard]] std::vector<Transit> transits(const System& system, const Members& members,
                                            std::size_t channel,
                                            const std::vector<Verdict>& verdicts,
                                            std::size_t gateway);

/// The rules of one channel. Entries of different channels never coincide, since they contain the
/// subject. Publishers of the admission `without` are left out.
[[nodiscard]] GateState gate_state(const System& system, const Members& members,
                                   std::size_t channel, const std::vector<Verdict>& verdicts,
                                   std::size_t gateway, AdmissionId without = 0);

/// The rules of all channels.
[[nodiscard]] GateState gate_state(const System& system, const Members& members,
                                   const std::vector<Decision>& decisions, std::size_t gateway);

/// The rules of one delivery; of its publisher alone, if the channel has several.
[[nodiscard]] GateState gate_state(const System& system, const Members& members,
                                   const Verdict& verdict, std::size_t gateway);

/// The most entries of one subject in one direction of a gate, of an Ethernet (ETHER_CHAIN in bpf/)
/// and of a CAN bus (GATE_CHAIN).
inline constexpr std::size_t kMostEntries = 8;
inline constexpr std::size_t kMostBusEntries = 16;
/// Why the gates of the gateway cannot hold the entries of a channel; nullopt if they can.
[[nodiscard]] std::optional<std::string> exceeds_capacity(const System& system,
                                                          const Members& members,
                                                          std::size_t channel,
                                                          const std::vector<Verdict>& verdicts,
                                                          std::size_t gateway);

/// A rule under which frames of several publishers of a channel arrive or leave, because the frames
/// do not state the publisher. It supervises the events of all of them together.
struct SharedRule {
  GateRule rule;
  std::vector<std::size_t> publishers;  ///< at least two
};
/// The shared rules of one channel, sorted by entry.
[[nodiscard]] std::vector<SharedRule> shared_rules(const System& system, const Members& members,
                                                   std::size_t channel,
                                                   const std::vector<Verdict>& verdicts,
                                                   std::size_t gateway);
/// The entries of these rules.
[[nodiscard]] std::vector<GateEntry> entries_of(const std::vector<SharedRule>& shared);

}  // namespace mlcca::core
