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
  std::uint64_t passed = 0;     ///< frames, at this gateway
  std::uint64_t dropped = 0;
  std::string reaction;  ///< worst-case reaction to a stopped heart-beat; empty: none
  bool operator==(const Channel&) const = default;
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
  bool operator==(const ChannelRequest&) const = default;
};

/// Would this be admitted? Changes nothing.
struct Query : ChannelRequest {
  bool operator==(const Query&) const = default;
};
struct Admit : ChannelRequest {
  bool operator==(const Admit&) const = default;
};

/// By channel (all of its run-time admissions) or by the id of one admission.
struct ReleaseRequest {
  std::string channel;
  std::uint64_t admission = 0;
  bool operator==(const ReleaseRequest&) const = default;
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
               ExplainRequest, MonitorRequest, ModeRequest, ReloadRequest>
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
  bool operator==(const Event&) const = default;
};

struct Reply {
  std::uint64_t id = 0;  ///< of the request; 0: an event, or the request could not be read
  std::variant<Error, Status, Networks, Channels, Done, Event> body;
  bool operator==(const Reply&) const = default;
};

}  // namespace mlcca::control
