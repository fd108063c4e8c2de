// SPDX-License-Identifier: BSD-2-Clause
// The control protocol as plain structs: one to one what proto/mlcca/v1/control.proto says, where
// every field and its unit is described. Nobody but codec.cc needs to know protobuf.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "control/parts.hpp"

namespace mlcca::control {

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

/// By which a CAN network carries a channel: identifier, etag, PGN, subject-id or COB-ID.
struct Identifier {
  std::string network;
  std::uint32_t id = 0;
  bool extended = false;  ///< of 29 bits; counts for profile raw
  bool operator==(const Identifier&) const = default;
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
  std::string address;    ///< of the new publisher, where frames carry the subject; empty: any
  /// The channel is a subject that the description does not have, where networks allow that.
  bool unlisted = false;
  std::vector<Identifier> identifiers;  ///< of such a channel, on each CAN network on its way
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

/// By channel (all of its run-time admissions) or by the id of one admission. What is described
/// stays.
struct ReleaseRequest {
  std::string channel;
  std::uint64_t admission = 0;
  std::string key;  ///< in place of the id
  bool operator==(const ReleaseRequest&) const = default;
};
/// Everything of a channel, what is described too, is refused until it is reinstated.
struct WithdrawRequest {
  std::string channel;
  bool operator==(const WithdrawRequest&) const = default;
};
struct ReinstateRequest {
  std::string channel;
  bool operator==(const ReinstateRequest&) const = default;
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
               RoutesRequest, ReservationsRequest, WhatIfRequest, HistoryRequest, GateRequest,
               WithdrawRequest, ReinstateRequest>
      body;
  bool slices = false;  ///< the reply may come in slices; Client sets it
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
  Health health = {};
  bool operator==(const Status&) const = default;
};

struct Networks {
  std::vector<Network> networks;
  bool operator==(const Networks&) const = default;
};

struct Channels {
  std::vector<Channel> channels;
  /// Of a new end: deliveries beyond those that are listed. What is refused is listed first.
  std::uint32_t left_out = 0;
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
  std::uint64_t silent_ns = 0;   ///< how long nothing has come, or had not
  std::uint64_t missing = 0;     ///< events in that time
  std::optional<Actor> by = {};  ///< who asked for it; nothing: the daemon did it by itself
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
  bool more = false;  ///< a slice; the next one has the same id
  bool operator==(const Reply&) const = default;
};

}  // namespace mlcca::control
