// SPDX-License-Identifier: BSD-2-Clause
// What messages of the control protocol are made of; see messages.hpp.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace mlcca::control {

enum class ErrorKind : std::uint8_t { unspecified, invalid, forbidden, unreadable, world };

/// How a value was held against another; what nobody stated is not fit.
enum class Outcome : std::uint8_t { unfit, fit, run_time };

/// The client at whose request something was changed.
struct Actor {
  std::uint32_t uid = 0;
  std::string user;       ///< empty: /etc/passwd does not name it
  std::uint32_t pid = 0;  ///< of the process that connected
  bool operator==(const Actor&) const = default;
};

/// What a monitoring system asks for; `unknown`: a daemon that does not say.
enum class HealthState : std::uint8_t { unknown, healthy, degraded, closed };
inline constexpr std::size_t kMostReasons = 32;
struct Health {
  HealthState state = HealthState::unknown;
  std::vector<std::string> reasons = {};  ///< one line each, at most kMostReasons
  std::uint32_t left_out = 0;             ///< reasons beyond those
  bool operator==(const Health&) const = default;
};

/// Value of one attribute in the unit of mlcca::kAttributeTable.
struct Attribute {
  std::string name;
  std::uint64_t value = 0;
  std::string unit;
  bool dynamic = false;
  bool operator==(const Attribute&) const = default;
};

struct ReasonCount {
  std::string reason;
  std::uint64_t frames = 0;
  bool operator==(const ReasonCount&) const = default;
};

struct Traffic {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t unknown = 0;  ///< part of dropped: frames without a slot
  std::vector<ReasonCount> reasons;
  std::uint64_t would_drop = 0;  ///< let through by audit mode; not part of dropped
  std::vector<ReasonCount> would_drop_reasons = {};
  bool operator==(const Traffic&) const = default;
};

/// Frames without a slot, seen lately.
struct Unknown {
  std::uint32_t can_id = 0;  ///< with the flags of <linux/can.h>
  std::uint32_t length = 0;
  bool fd = false;
  bool egress = false;
  std::uint64_t frames = 0;
  std::uint64_t subject = 0;  ///< on Ethernet, where can_id is 0
  bool xl = false;
  std::string address = {};  ///< on Ethernet: of the latest sender, as far as it is known
  std::string mac = {};
  bool operator==(const Unknown&) const = default;
};

struct Interface {
  std::string name;
  std::uint32_t ifindex = 0;  ///< 0: not there
  std::string network;
  std::string identity;
  std::string profile;
  bool managed = false;
  bool up = false;
  std::string can_state;
  std::uint32_t bitrate = 0;  ///< bit/s, 0: unknown
  bool gated = false;
  std::uint32_t slots = 0;
  Traffic ingress;
  Traffic egress;
  std::vector<Unknown> unknown;  ///< newest first
  std::string problem;           ///< empty: none
  bool drops_early = false;      ///< Ethernet: what is refused is dropped in the driver
  std::string hook;              ///< "tcx" or "clsact"; empty: not gated
  std::string drift;             ///< of the gate, not to be repaired; empty: none
  std::uint64_t repaired = 0;    ///< how often the gate was put back, or first
  std::uint64_t bypassed = 0;    ///< frames sent past the gate
  bool operator==(const Interface&) const = default;
};

struct Network {
  std::string name;
  std::string kind;
  std::string profile;
  std::vector<Attribute> provision;
  bool capacity_known = false;
  std::uint64_t capacity = 0;  ///< bytes/s
  std::uint64_t reserved = 0;  ///< bytes/s
  bool available = false;
  std::string problem;  ///< why it is not available
  std::vector<std::string> gateways;
  bool operator==(const Network&) const = default;
};

/// One attribute held against one hop, the route, the publisher or a capacity.
struct Row {
  std::string where;  ///< name of the hop; "end to end"; "publisher NAME"; "capacity of NAME"
  std::string attribute;
  std::string unit;
  std::uint64_t required = 0;
  bool provided_known = false;
  std::uint64_t provided = 0;
  bool dynamic = false;
  Outcome outcome = Outcome::unfit;
  std::string margin;
  bool operator==(const Row&) const = default;
};

/// What an analysed medium gives a channel: times on a CAN bus, rates on a mesh.
struct MediumUse {
  std::string network;
  std::uint64_t response_ns = 0;    ///< as the bus is now; 0: no bus
  std::uint64_t guaranteed_ns = 0;  ///< whoever comes later cannot exceed it
  std::uint64_t paper_rate = 0;     ///< bytes/s, 1 / sum(1 / R) over the links; 0: no mesh
  std::uint64_t available = 0;      ///< payload bytes/s left now, and what it holds
  std::string limiting_domain;
  std::vector<std::string> nodes;  ///< of the mesh, in the order of travel
  bool operator==(const MediumUse&) const = default;
};

/// How the events of a periodic publisher come to the gate that they enter by.
struct Watch {
  std::uint64_t period_ns = 0;
  std::uint64_t silence_ns = 0;  ///< so long without an event is an exception; 0: never
  bool missing_now = false;      ///< the exception is in force
  std::uint64_t events = 0;
  std::uint64_t missing = 0;
  std::uint64_t since_last_ns = 0;
  std::uint64_t last_gap_ns = 0;
  std::uint64_t shortest_gap_ns = 0;
  std::uint64_t longest_gap_ns = 0;
  std::uint64_t jitter_ns = 0;      ///< furthest that a gap was from the period
  std::uint64_t rate_mhz = 0;       ///< 0: unknown
  std::vector<std::uint64_t> gaps;  ///< by eighths of the period; the last: or longer
  bool operator==(const Watch&) const = default;
};

inline constexpr std::size_t kListedSubscribers = 256;
inline constexpr std::size_t kListedRows = 256;
/// One publisher of a subject towards one place, decided.
struct Channel {
  std::uint64_t subject = 0;
  std::string name;
  std::string description;
  std::string publisher;
  std::string from;
  std::string to;
  std::vector<std::string> subscribers;  ///< the first kListedSubscribers
  bool granted = false;
  std::string reason;  ///< one line
  std::vector<std::string> route;
  std::vector<Row> rows;        ///< kListedRows at most, before all others those that do not fit
  std::uint64_t admission = 0;  ///< id of the run-time admission, 0: described
  std::uint32_t set = 0;        ///< attribute set in use, 0 is the preferred one
  std::uint32_t sets = 1;       ///< how many there are
  std::uint32_t importance = 0;
  std::vector<MediumUse> media;
  std::uint64_t passed = 0;  ///< frames, at this gateway
  std::uint64_t dropped = 0;
  std::uint64_t excess = 0;  ///< beyond the admitted traffic, dropped or not
  std::string reaction;      ///< worst-case reaction to a stopped heart-beat; empty: none
  std::optional<Watch> watch;
  std::vector<std::string> troubles = {};  ///< what is wrong with what was granted, one line each
  std::uint32_t subscribers_left_out = 0;  ///< beyond those that are listed
  bool withdrawn = false;                  ///< an operator has withdrawn the channel
  std::uint64_t would_drop = 0;            ///< let through by audit mode; not part of dropped
  std::uint32_t rows_left_out = 0;         ///< beyond those that are listed
  bool operator==(const Channel&) const = default;
};

/// A link of a mesh as a source reports it and as it is believed to be.
struct MeshLink {
  std::string network;
  std::string from;  ///< described name, or address
  std::string to;
  std::uint64_t rate = 0;           ///< bit/s as reported, 0: unknown
  std::uint64_t believed_rate = 0;  ///< bit/s, 0: carries nothing
  std::string kind;                 ///< phy, effective, derived
  bool loss_known = false;
  std::uint64_t loss = 0;  ///< 1e-9
  bool busy_known = false;
  std::uint32_t busy = 0;  ///< 1e-6 of the medium's time
  std::uint64_t age_ns = 0;
  bool stale = false;
  std::string source;
  std::string lack;  ///< gone, absent, rate unknown, must last: why it carries nothing
  bool operator==(const MeshLink&) const = default;
};

/// A rule of can-gw between two CAN interfaces, mlccad's or somebody else's.
struct CanRule {
  std::string from;  ///< interface
  std::string to;
  std::uint32_t id = 0;  ///< frames with (can_id & mask) == id, as struct can_filter has it
  std::uint32_t mask = 0;
  bool fd = false;
  bool ours = false;
  std::string channel;        ///< for which it was made, of ours
  std::string change;         ///< made to the frames on their way; empty: none
  std::uint32_t hops = 0;     ///< limit of its own, 0: none
  std::uint64_t handled = 0;  ///< frames
  std::uint64_t dropped = 0;
  std::uint64_t deleted = 0;  ///< for too many hops
  bool operator==(const CanRule&) const = default;
};

/// A way that channels take or would take, between two places.
struct RouteReport {
  std::string from;
  std::string to;
  std::vector<std::string> places;  ///< both ends included; empty: there is none
  std::uint32_t granted = 0;        ///< channels
  std::uint32_t refused = 0;
  std::vector<MediumUse> media;  ///< what it gives now; response_ns: the longest of its channels
  std::string problem;
  bool operator==(const RouteReport&) const = default;
};

/// What one flow has been promised of a resource.
struct Reservation {
  std::string channel;
  std::string publisher;
  std::uint64_t amount = 0;     ///< in the unit of the resource
  std::uint64_t admission = 0;  ///< 0: described
  std::uint32_t set = 0;
  std::uint32_t importance = 0;
  std::uint64_t lease_ns = 0;  ///< what is left of the lease, 0: none
  bool operator==(const Reservation&) const = default;
};

/// A network or gateway (bytes/s), a CAN bus (1e-6 of its time), a domain of a mesh (1e-12 of its
/// time).
struct Resource {
  std::string name;  ///< "robot-can", "robot-can: bus time", "awds: all links"
  std::string kind;  ///< network, gateway, bus, domain
  std::string unit;  ///< bytes/s, ppm, ps/s
  bool capacity_known = false;
  std::uint64_t capacity = 0;
  std::uint64_t reserved = 0;
  std::uint64_t background = 0;  ///< taken by others
  std::vector<Reservation> reservations;
  bool operator==(const Resource&) const = default;
};

/// What would become of one delivery.
struct Outlook {
  std::string channel;
  std::string publisher;
  std::string to;
  bool granted_now = false;
  bool granted_then = false;
  std::uint32_t set_now = 0;
  std::uint32_t set_then = 0;
  std::string reason;  ///< then, in one line
  bool operator==(const Outlook&) const = default;
};

struct HistoryEntry {
  std::uint64_t unix_ns = 0;
  std::string kind;
  std::uint64_t subject = 0;
  std::string channel;
  std::string from;
  std::string to;
  std::string network;
  std::string message;
  std::optional<Actor> by = {};
  bool operator==(const HistoryEntry&) const = default;
};

/// One slot of a gate: what it admits, how much of it, and what became of the frames.
struct GateSlot {
  std::string name;  ///< kind of control traffic, or channel
  bool egress = false;
  bool passes = false;
  std::uint32_t id = 0;  ///< (can_id & mask) == id, with the flags of <linux/can.h>
  std::uint32_t mask = 0;
  std::string formats;
  std::uint32_t max_length = 0;
  std::string source;              ///< egress: interface, "user 1000", "any user", "kernel"
  std::uint64_t per_frame_ns = 0;  ///< with per_byte 0: not policed
  std::uint64_t per_byte = 0;      ///< 2^-8 ns
  std::uint64_t tolerance_ns = 0;
  bool excess_passes = false;
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t excess = 0;
  std::uint64_t bytes = 0;
  std::string last_reason;       ///< of the latest drop, or of what would be one; empty: none
  std::uint64_t would_drop = 0;  ///< let through by audit mode; not part of dropped
  bool operator==(const GateSlot&) const = default;
};

struct Gate {
  std::string interface;
  std::string network;
  std::string profile;
  bool attached = false;
  std::string problem;
  std::uint32_t slots = 0;
  std::uint32_t room = 0;
  std::uint32_t masked = 0;        ///< of the direction that has more of them
  std::uint32_t masked_room = 0;   ///< 0: an Ethernet gate, which goes by subject
  std::vector<GateSlot> control;   ///< Ethernet: what is left alone
  std::vector<GateSlot> channels;  ///< the first 4096
  bool operator==(const Gate&) const = default;
};

}  // namespace mlcca::control
