// SPDX-License-Identifier: BSD-2-Clause
// The control protocol as plain structs: one to one what proto/mlcca/v1/control.proto says, where
// every field and its unit is described. Nobody but codec.cc needs to know protobuf.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mlcca::control {

// --- parts of messages ---------------------------------------------------------------------------

enum class ErrorKind : std::uint8_t { unspecified, invalid, forbidden, unreadable, world };

/// How a value was held against another; what nobody stated is not fit.
enum class Outcome : std::uint8_t { unfit, fit, run_time };

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

/// One publisher of a subject towards one place, decided.
struct Channel {
  std::uint64_t subject = 0;
  std::string name;
  std::string description;
  std::string publisher;
  std::string from;
  std::string to;
  std::vector<std::string> subscribers;
  bool granted = false;
  std::string reason;  ///< one line
  std::vector<std::string> route;
  std::vector<Row> rows;
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
  std::string last_reason;  ///< of the latest drop; empty: none
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
  std::uint32_t masked = 0;  ///< of the direction that has more of them
  std::uint32_t masked_room = 0;
  std::vector<GateSlot> control;
  std::vector<GateSlot> channels;
  bool operator==(const Gate&) const = default;
};

// --- requests ------------------------------------------------------------------------------------

struct StatusRequest {
  bool operator==(const StatusRequest&) const = default;
};
struct NetworksRequest {
  bool operator==(const NetworksRequest&) const = default;
};
struct ChannelsRequest {
  bool operator==(const ChannelsRequest&) const = default;
};

struct ChannelRequest {
  std::string channel;              ///< name or 0x… subject
  std::string from;                 ///< place of a new publisher; empty: the known ones
  std::string to;                   ///< place of a new subscriber; empty: the known ones
  std::vector<Attribute> offered;   ///< of the new publisher, over the channel's attributes
  std::vector<Attribute> required;  ///< of the new subscriber, over the channel's attributes
  std::optional<std::uint32_t> node;
  std::optional<std::uint32_t> priority;
  std::string user;
  std::string subscriber;
  std::string publisher;
  std::string from_node;  ///< node of the mesh `from` that the new publisher is at; empty: any
  std::string to_node;    ///< the same for the new subscriber, of the mesh `to`
  bool operator==(const ChannelRequest&) const = default;
};

/// Would this be admitted? Changes nothing.
struct Query : ChannelRequest {
  bool operator==(const Query&) const = default;
};
struct Admit : ChannelRequest {
  /// The client's own name for this admission: asked again it is answered again, and not admitted
  /// twice. Empty: none.
  std::string key;
  std::uint64_t lease_ns = 0;  ///< released unless it is renewed in that time; 0: never
  /// Renewed as long as this connection is open, which gets the events that concern it.
  bool hold = false;
  bool operator==(const Admit&) const = default;
};

/// By channel (all of its run-time admissions) or by the id of one admission.
struct ReleaseRequest {
  std::string channel;
  std::uint64_t admission = 0;
  std::string key;  ///< in place of the id
  bool operator==(const ReleaseRequest&) const = default;
};
/// The lease of an admission starts anew. By id or by key.
struct RenewRequest {
  std::uint64_t admission = 0;
  std::string key;
  bool operator==(const RenewRequest&) const = default;
};
struct RoutesRequest {
  bool operator==(const RoutesRequest&) const = default;
};
struct ReservationsRequest {
  std::string place;  ///< network or gateway; empty: all
  bool operator==(const ReservationsRequest&) const = default;
};

/// A link of a mesh as it might be.
struct LinkChange {
  std::string network;  ///< empty: the only mesh
  std::string from;     ///< node, by name or address
  std::string to;
  std::uint64_t rate = 0;  ///< bit/s, 0: gone
  bool both_ways = true;
  bool operator==(const LinkChange&) const = default;
};
/// Who would lose, who would gain? Changes nothing.
struct WhatIfRequest {
  std::vector<LinkChange> links;
  std::vector<std::string> without;  ///< networks and gateways that are not there
  bool operator==(const WhatIfRequest&) const = default;
};
struct HistoryRequest {
  std::string channel;  ///< empty: all
  std::string kind;     ///< empty: all
  std::uint64_t since_unix_ns = 0;
  std::uint64_t until_unix_ns = 0;  ///< 0: now
  std::uint32_t limit = 0;          ///< newest first; 0: 100, at most 10000
  bool operator==(const HistoryRequest&) const = default;
};
/// What do the gates hold?
struct GateRequest {
  std::string place;  ///< interface or network; empty: all
  bool operator==(const GateRequest&) const = default;
};
struct ExplainRequest {
  std::string channel;
  bool operator==(const ExplainRequest&) const = default;
};
struct MonitorRequest {
  bool operator==(const MonitorRequest&) const = default;
};
struct ModeRequest {
  std::string mode;  ///< enforce, audit
  bool operator==(const ModeRequest&) const = default;
};
struct ReloadRequest {
  bool operator==(const ReloadRequest&) const = default;
};

struct Request {
  std::uint64_t id = 0;  ///< copied into the reply
  std::variant<StatusRequest, NetworksRequest, ChannelsRequest, Query, Admit, ReleaseRequest,
               ExplainRequest, MonitorRequest, ModeRequest, ReloadRequest, RenewRequest,
               RoutesRequest, ReservationsRequest, WhatIfRequest, HistoryRequest, GateRequest>
      body;
  bool operator==(const Request&) const = default;
};

// --- replies -------------------------------------------------------------------------------------

struct Error {
  ErrorKind kind = ErrorKind::unspecified;
  std::string message;
  std::vector<std::string> details;
  bool operator==(const Error&) const = default;
};

struct Done {
  std::string message;
  bool operator==(const Done&) const = default;
};

struct Status {
  std::string version;
  std::string gateway;
  std::string system;
  std::string description_file;
  std::string mode;  ///< enforce, audit
  bool open = false;
  std::uint64_t grace_ns = 0;  ///< 2^64-1: for ever
  std::uint64_t lapses = 0;
  std::uint32_t channels_granted = 0;
  std::uint32_t channels_refused = 0;
  std::uint64_t started_unix_s = 0;
  std::uint64_t loaded_unix_s = 0;
  std::string last_error;
  std::vector<Interface> interfaces;
  std::string problem;
  bool operator==(const Status&) const = default;
};

struct Networks {
  std::vector<Network> networks;
  bool operator==(const Networks&) const = default;
};

struct Channels {
  std::vector<Channel> channels;
  bool operator==(const Channels&) const = default;
};

struct Event {
  std::uint64_t unix_ns = 0;
  std::string kind;
  std::uint64_t subject = 0;  ///< 0: not about a subject
  std::string channel;
  std::string network;
  std::string message;  ///< one line
  /// Run-time admissions that it concerns: sent to whoever holds one of them, too.
  std::vector<std::uint64_t> admissions;
  // Of missing and restored:
  std::uint64_t silent_ns = 0;  ///< how long nothing has come, or had not
  std::uint64_t missing = 0;    ///< events in that time
  bool operator==(const Event&) const = default;
};

struct Gates {
  std::vector<Gate> gates;
  bool operator==(const Gates&) const = default;
};

struct Routes {
  std::vector<RouteReport> routes;
  std::vector<MeshLink> links;
  std::vector<std::string> problems;  ///< of sources: "awds: nl80211 mesh0: …"; of forwarding
  std::vector<CanRule> can_rules;
  bool operator==(const Routes&) const = default;
};

struct Reservations {
  std::vector<Resource> resources;
  bool operator==(const Reservations&) const = default;
};

struct WhatIf {
  std::vector<Outlook> outlooks;  ///< of everything that would change
  std::uint32_t unchanged = 0;    ///< deliveries that would not
  bool operator==(const WhatIf&) const = default;
};

struct History {
  std::vector<HistoryEntry> entries;
  bool operator==(const History&) const = default;
};

struct Reply {
  std::uint64_t id = 0;  ///< of the request; 0: an event, or the request could not be read
  std::variant<Error, Status, Networks, Channels, Done, Event, Routes, Reservations, WhatIf,
               History, Gates>
      body;
  bool operator==(const Reply&) const = default;
};

}  // namespace mlcca::control
