// SPDX-License-Identifier: BSD-2-Clause
// From verdicts to what the gates of one gateway must hold, and the difference of two such states.
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

/// What one slot of a gate admits or refuses: everything that was granted and nothing more.
/// Where frames carry the subject, key, id and mask are 0.
struct GateEntry {
  std::size_t port = 0;  ///< of this gateway
  Direction direction = Direction::ingress;
  std::uint32_t id = 0;  ///< a frame fits when (can_id & mask) == id
  std::uint32_t mask = 0;
  std::optional<std::size_t>
      source_port;           ///< egress: where the frame came in; none: a local program
  FrameIdentity entered_as;  ///< egress, from another bus: what it was admitted as there
  std::uint32_t uid = 0;     ///< egress, local program: its user
  bool from_kernel = false;  ///< egress: of no program, but of a protocol in the kernel
  Station station;           ///< Ethernet: who sent the frame; a wildcard: who has no other entry
  std::uint16_t max_length = 0;  ///< payload bytes of a frame or datagram, or of a message
  bool classic = false;
  bool fd = false;
  bool xl = false;
  bool fragmented = false;  ///< Ethernet: a datagram may hold a fragment of an event
  bool transport = false;   ///< CAN: transport_of() carries what is longer than a frame
  Subject subject = 0;

  /// Payload bytes of a frame or datagram.
  [[nodiscard]] std::uint16_t frame_length() const { return transport ? 8 : max_length; }
  auto operator<=>(const GateEntry&) const = default;
};

/// How much of what an entry admits: the admitted traffic, as the generic cell rate algorithm takes
/// it (ITU-T I.371, virtual scheduling). A frame costs per_frame + its bytes * per_byte and may
/// come `tolerance` before its turn. Nothing costs anything: not policed.
struct Policing {
  Value per_frame = 0;       ///< ns
  Value per_byte = 0;        ///< 2^-8 ns
  Value tolerance = 0;       ///< ns
  bool counts_only = false;  ///< what is too much is counted and passes
  bool operator==(const Policing&) const = default;
  [[nodiscard]] bool any() const { return per_frame != 0 || per_byte != 0; }
};

/// How the events of an entry are expected to come. Without a period there is no silence timer.
struct Watching {
  Value period = 0;    ///< ns between events, as the publisher states it
  Value silence = 0;   ///< ns without an event that are too long; 0: no subscriber minds
  Value together = 0;  ///< ns: frames closer than this to the first one of an event belong to it
  bool operator==(const Watching&) const = default;
};

struct GateRule {
  GateEntry entry;
  bool pass = false;
  Policing policing;
  Watching watching;
  bool operator==(const GateRule&) const = default;
};

/// The gates of one gateway, sorted by entry; each entry occurs once. Where two publishers cannot
/// be distinguished on the wire, the frames pass only if both may.
using GateState = std::vector<GateRule>;

/// What leads from one state to the next, in one step for frames.
struct GateChanges {
  std::vector<GateEntry> close;
  std::vector<GateEntry> remove;
  std::vector<GateRule> add;  ///< denied at first, opened with the others where they pass
  std::vector<GateEntry> open;
  std::vector<GateRule> police;  ///< entries that stay, with what is admitted or expected now
  [[nodiscard]] bool empty() const {
    return close.empty() && remove.empty() && add.empty() && open.empty() && police.empty();
  }
  bool operator==(const GateChanges&) const = default;
};
[[nodiscard]] GateChanges difference(const GateState& now, const GateState& next);

/// The traffic of a publisher that states these attributes, in frames that are `frames` to the
/// event: one event each Period, or Bandwidth bytes/s in events of MaxPayload; 500 ppm more, since
/// clocks differ, and one event and its Jitter early. Without either nothing is policed.
[[nodiscard]] Policing policing_of(const AttributeSet& offered, std::uint64_t frames,
                                   Value largest = 1);

/// So long nothing may come to a gate before more events are missing than a delivery allows, ns:
/// (Omission + 1) * Period + Jitter, 500 ppm more, since clocks differ: the worst-case reaction
/// less the Latency. 0: unknown, or nothing was granted.
[[nodiscard]] Value silence_of(const Verdict& verdict);

/// The same of a delivery from program to program on one gateway, where nothing is in between: a
/// Jitter that is not stated is none.
[[nodiscard]] Value silence_here(const Verdict& verdict);

/// Granted events of a publisher at a gateway: how their frames enter it and how they leave it.
struct Passage {
  std::size_t publisher = 0;
  std::size_t set = 0;             ///< attribute set in use
  std::optional<GateEntry> in{};   ///< none: the publisher is a program on the gateway
  std::optional<GateEntry> out{};  ///< none: a subscriber is
  bool by_kernel = false;          ///< from port to port, and no program carries them
  auto operator<=>(const Passage&) const = default;
};
/// Of one channel, sorted, each once.
[[nodiscard]] std::vector<Passage> passages(const System& system, const Members& members,
                                            std::size_t channel,
                                            const std::vector<Verdict>& verdicts,
                                            std::size_t gateway);

/// What of it the kernel carries from one bus to another.
struct Transit {
  GateEntry in;
  GateEntry out;
  auto operator<=>(const Transit&) const = default;
};
/// Of one channel, sorted, each once.
[[nodiscard]] std::vector<Transit> transits(const System& system, const Members& members,
                                            std::size_t channel,
                                            const std::vector<Verdict>& verdicts,
                                            std::size_t gateway);

/// The part of one channel. Entries of different channels never meet: they carry the subject.
/// Publishers of the admission `without` are left out.
[[nodiscard]] GateState gate_state(const System& system, const Members& members,
                                   std::size_t channel, const std::vector<Verdict>& verdicts,
                                   std::size_t gateway, AdmissionId without = 0);

[[nodiscard]] GateState gate_state(const System& system, const Members& members,
                                   const std::vector<Decision>& decisions, std::size_t gateway);

/// The part of one delivery: of its publisher alone, where its channel has several.
[[nodiscard]] GateState gate_state(const System& system, const Members& members,
                                   const Verdict& verdict, std::size_t gateway);

/// Entries of one subject that a gate holds in one direction (GATE_CHAIN).
inline constexpr std::size_t kMostEntries = 8;
/// Why the gates of the gateway cannot hold the entries of a channel; nothing where they can.
[[nodiscard]] std::optional<std::string> exceeds_capacity(const System& system,
                                                          const Members& members,
                                                          std::size_t channel,
                                                          const std::vector<Verdict>& verdicts,
                                                          std::size_t gateway);

/// The rule by which events of several publishers of a channel come or leave: frames do not say
/// whose they are. What it expects are events of any of them.
struct SharedRule {
  GateRule rule;
  std::vector<std::size_t> publishers;  ///< two at least
};
/// Of one channel, sorted by entry.
[[nodiscard]] std::vector<SharedRule> shared_rules(const System& system, const Members& members,
                                                   std::size_t channel,
                                                   const std::vector<Verdict>& verdicts,
                                                   std::size_t gateway);
[[nodiscard]] std::vector<GateEntry> entries_of(const std::vector<SharedRule>& shared);

}  // namespace mlcca::core
