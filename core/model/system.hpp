// SPDX-License-Identifier: BSD-2-Clause
// The described world as plain structs: what description/ reads and what every decision starts
// from. Things refer to each other by index; nothing here has behaviour other than look-up.
#pragma once
#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/model/origin.hpp"
#include "core/model/station.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core {

/// 64-bit identity of a channel, unique over all networks.
using Subject = std::uint64_t;

/// An attribute that the description adds to the table of mlcca/attribute.hpp.
struct UserAttribute {
  std::string name;
  Better better = Better::smaller;
  Composition composition = Composition::sum;  ///< sum, slowest, smallest or survival
  std::string unit;   ///< in words: "K", "m s^-1"; empty for a plain number
  int magnitude = 0;  ///< values are whole multiples of 10^magnitude of the unit
  Origin origin;
};

/// The value of a user-defined attribute.
struct UserValue {
  std::uint32_t attribute = 0;  ///< index into System::user_attributes
  bool dynamic = false;         ///< provided as a best case only
  Value value = 0;
  bool operator==(const UserValue&) const = default;
};
/// Sorted by attribute, each at most once.
using UserValues = std::vector<UserValue>;

/// One of several attribute sets of a channel, or of one of its ends.
struct Alternative {
  std::int32_t priority = 0;  ///< larger is preferred
  AttributeSet attributes;
  UserValues user;
};

/// Where a subject stands when its events are dropped.
enum class SafeSide : std::uint8_t {
  unstated,
  drop,     ///< silence is safe: a heart-beat
  deliver,  ///< silence is a danger: a message that must arrive to stop something
};

/// Largest number of hops (networks and gateways) of a route. Longer ones are not found.
inline constexpr std::size_t kMaxHops = 16;

enum class NetworkKind : std::uint8_t {
  can,
  udp_multicast,
  udp_broadcast,
  mesh,
  ieee802154,
  other,
};

/// How frames on the network's interfaces name their subject.
enum class Profile : std::uint8_t {
#define PROFILE(word, NAME) word,
#include "core/profiles/list.inc"
};
inline constexpr std::size_t kProfileCount = 0
#define PROFILE(word, NAME) +1  // NOLINT(bugprone-macro-parentheses): a summand
#include "core/profiles/list.inc"
    ;

/// Which CAN frame formats a binding allows; any: classic and FD.
enum class FrameFormat : std::uint8_t { classic, fd, any, xl };

/// The subject of a channel on one network: what the profile calls it.
struct Binding {
  std::size_t channel = 0;  ///< index into System::channels
  std::uint32_t id = 0;     ///< identifier (raw), etag, PGN, subject-id or COB-ID
  /// famouso: the etag is what the broker deals at run time; until it is known `id` is 0.
  bool dynamic = false;
  bool extended = false;  ///< 29-bit identifiers; raw: as stated, else as the profile has them
  FrameFormat format = FrameFormat::classic;
  bool remote_frames = false;               ///< RTR frames are part of the channel (default: never)
  std::optional<std::uint8_t> priority;     ///< j1939, cyphal: 0 (highest) to 7; none: any
  std::optional<std::uint8_t> destination;  ///< j1939, PDU1: address; none: any
  std::uint32_t mask = 0x1fffffff;          ///< raw: bits of the identifier that count
  Origin origin;

  /// No frame can have it yet.
  [[nodiscard]] bool waits_for_tag() const { return dynamic && id == 0; }
  /// It names a range of identifiers.
  [[nodiscard]] bool is_masked() const {
    const std::uint32_t whole = extended ? 0x1fffffff : 0x7ff;
    return (mask & whole) != whole;
  }
};

/// At most `count` errors on the bus in any `interval`, ns. count 0: errors are not expected.
struct FaultHypothesis {
  std::uint32_t count = 0;
  Value interval = 0;
  bool operator==(const FaultHypothesis&) const = default;
};

/// What is stated of a CAN bus in addition to what is admitted onto it.
struct CanBus {
  std::uint32_t bitrate = 0;       ///< bit/s, 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s of the FD data phase, 0: classic frames only
  bool unknown_senders = false;    ///< a station that is not described may send: any frame may
                                   ///< block
  std::uint32_t background = 0;    ///< 1e-6 of the bus time that others take, at any priority
  bool measured = true;            ///< measured load above the admitted one counts as unaccounted
                                   ///< load
  FaultHypothesis faults;
  bool operator==(const CanBus&) const = default;
};

/// What of a profile's control traffic (core/gates/control_traffic.hpp) passes a gate.
struct ControlPolicy {
  std::optional<std::uint32_t> kinds;  ///< a bit for each kind, in their order; none: the default
  std::uint32_t rate = 0;              ///< frames/s of each kind; 0: the kind's own
  bool operator==(const ControlPolicy&) const = default;
};

/// Which channels that the description does not have may be admitted onto a network at run time.
struct UnlistedPolicy {
  bool allowed = false;
  Subject subject = 0;      ///< subjects with the same leading `bits` bits
  std::uint8_t bits = 0;    ///< 0: every subject
  std::uint32_t most = 16;  ///< such channels at once, 1 to 256

  /// `subject` with 0 for the bits that do not count.
  [[nodiscard]] Subject leading() const {
    return bits == 0 ? 0 : subject >> (64U - bits) << (64U - bits);
  }
  [[nodiscard]] bool admits(Subject s) const {
    return allowed && (bits == 0 || (s ^ subject) >> (64U - bits) == 0);
  }
};

/// Whose subscriptions count that come over a network of FAMOUSO, by its subject SUBSCRIB.
enum class Subscribing : std::uint8_t {
  nobody,
  gateways,         ///< nobody's: gateways announce themselves there, and that is all
  with_attributes,  ///< of who states what it requires
  all,              ///< of FAMOUSO's own nodes, too: they require what the channel states
};
struct SubscriptionPolicy {
  Subscribing accept = Subscribing::nobody;
  std::uint32_t most = 64;  ///< that come over the network, at once, 1 to 1024
  Origin origin;
};

struct Network {
  std::string name;
  NetworkKind kind = NetworkKind::can;
  Profile profile = Profile::none;
  CanBus bus;  ///< of a CAN network
  ControlPolicy control;
  /// Of a FAMOUSO bus: the etag of the subject SUBSCRIB, which all its nodes subscribe by; 0: not
  /// known. `states_subscribe_tag`: the description says it.
  std::uint32_t subscribe_tag = 0;
  bool states_subscribe_tag = false;
  UnlistedPolicy unlisted;
  SubscriptionPolicy subscriptions;
  std::optional<mesh::Mesh> mesh;  ///< of a mesh whose routes are evaluated
  AttributeSet provision;          ///< static provision; a dynamic mark makes it a best case
  UserValues user;
  std::vector<Binding> bindings;  ///< State sorts them by channel
  Origin origin;

  /// Frames name the 64-bit subject itself: Ethernet and networks with Ethernet frames. No channel
  /// is bound.
  [[nodiscard]] bool carries_subjects() const;
  /// For bindings that are sorted by channel.
  [[nodiscard]] const Binding* binding_of(std::size_t channel) const {
    const auto it = std::ranges::lower_bound(bindings, channel, {}, &Binding::channel);
    return it != bindings.end() && it->channel == channel ? &*it : nullptr;
  }
};

/// What an interface is recognised by; every part that is given must match.
struct InterfaceIdentity {
  std::string name;              ///< kernel name
  std::string id_path;           ///< udev ID_PATH
  std::string serial;            ///< udev ID_SERIAL_SHORT
  std::string alias;             ///< ifalias
  std::optional<unsigned> port;  ///< dev_port or dev_id, for adapters with several channels

  auto operator<=>(const InterfaceIdentity&) const = default;
};

/// How a gateway's frames wait for the bus.
enum class Queueing : std::uint8_t {
  fifo,      ///< in the order in which they came: what Linux does unless it is configured otherwise
  priority,  ///< the frame that wins arbitration first; mlccad sets the queueing discipline up
};

/// What becomes of excess frames: those above the admitted traffic.
enum class Excess : std::uint8_t {
  drop,
  pass,  ///< they are counted only
};

/// What the program that sent a frame gets as the result when the gate drops it on its way out.
enum class Refused : std::uint8_t {
  error,   ///< ENOBUFS, as of a full queue
  silent,  ///< success: for programs that end at the first error
};

/// Who carries admitted events from one network of a gateway to another.
enum class Forwarder : std::uint8_t {
  relay,   ///< between CAN buses can-gw, by rules that mlccad makes; else mlcca-relay
  can_gw,  ///< between CAN buses the same; between others the kernel; else the sender of a port
  none,    ///< as can_gw, and mlccad makes no rules
};

/// One interface of a gateway, on one network.
struct Port {
  std::size_t network = 0;
  InterfaceIdentity identity;
  bool managed = false;            ///< mlccad sets bit rates and brings it up
  std::uint32_t bitrate = 0;       ///< bit/s, 0: not set by us
  std::uint32_t data_bitrate = 0;  ///< bit/s of the FD data phase, 0: classic only
  Queueing queueing = Queueing::fifo;
  std::uint32_t fifo_depth = 1;     ///< frames that the controller holds behind the queue, 1 to 64
  std::uint32_t queue_length = 10;  ///< frames that fit the queue before one is lost, 1 to 10000
  Excess excess = Excess::drop;
  Refused refused = Refused::error;
  ControlPolicy control;          ///< what it states goes before what the network states
  std::uint32_t control_uid = 0;  ///< user whose programs may send control traffic
  /// FAMOUSO's number of this gateway on its bus, as which it asks the broker for tags.
  std::optional<std::uint8_t> node;
  /// The user whose program, and not mlcca-relay, sends here what the kernel does not carry.
  std::optional<std::uint32_t> sender;
  Origin origin;
};

/// A host that joins networks. It is a hop too: it forwards with a provision of its own.
struct Gateway {
  std::string name;
  std::string host;  ///< host name of the machine, empty: not stated
  AttributeSet provision;
  UserValues user;
  Forwarder forwarder = Forwarder::relay;
  /// It announces itself on its networks in this interval, ns, and another gateway takes its place
  /// when it fails; 0: it does not.
  Value presence = 0;
  std::optional<std::uint32_t> relay;  ///< user of mlcca-relay; none: this machine has no such user
  std::vector<Port> ports;
  Origin origin;

  [[nodiscard]] const Port* port_on(std::size_t network) const {
    for (const auto& p : ports)
      if (p.network == network) return &p;
    return nullptr;
  }
};

struct EventChannel {
  std::string name;  ///< short name; unique
  Subject subject = 0;
  std::string description;
  SafeSide safe_side = SafeSide::unstated;
  std::uint8_t importance = 0;  ///< larger is kept longer and served earlier when networks change
  AttributeSet attributes;      ///< default for publishers and subscribers of the channel
  UserValues user;
  std::int32_t priority = 0;       ///< of these attributes, where there are further sets
  std::vector<Alternative> lower;  ///< the further sets, priorities falling
  /// It is not described: admitted at run time, or without a name and free for that.
  bool unlisted = false;
  Origin origin;
};

/// A network (any node on it) or a gateway (a program on that host).
struct Place {
  enum class Kind : std::uint8_t { network, gateway };
  Kind kind = Kind::network;
  std::size_t index = 0;
  auto operator<=>(const Place&) const = default;
};

/// The component of an end that belongs to none.
inline constexpr std::uint32_t kNoComponent = 0xffffffff;

/// What a program on a gateway must be to take up an end, beside the user of a publisher: all of
/// it.
struct ProgramRule {
  std::optional<std::uint32_t> gid;  ///< it is in that group
  std::string group;                 ///< as it was stated
  std::string unit;                  ///< it runs in that unit of systemd; empty: in any
  bool operator==(const ProgramRule&) const = default;
};
/// Of System::program_rules: none.
inline constexpr std::uint32_t kAnyProgram = 0xffffffff;

struct Publisher {
  std::string name;
  std::size_t channel = 0;
  Place place;
  AttributeSet attributes;  ///< effective: Period, MaxPayload, Jitter and Bandwidth are its
                            ///< traffic, the others requirements of its own
  UserValues user;
  std::vector<Alternative> lower;  ///< the same in each of the channel's further sets
  std::uint32_t component = kNoComponent;
  std::optional<std::uint8_t> node;        ///< its number where the profile has one
  std::optional<std::uint32_t> mesh_node;  ///< on a mesh: index into its nodes; none: any of them
  Station station;                   ///< what its frames come from, where they carry the subject
  std::uint8_t priority = 0x7d;      ///< famouso, 0 (highest)..127
  std::optional<std::uint32_t> uid;  ///< on a gateway: the user that may send
  std::uint32_t program_rule = kAnyProgram;  ///< on a gateway: see System::program_rules
  Origin origin;
};

struct Subscriber {
  std::string name;
  std::size_t channel = 0;
  Place place;
  AttributeSet attributes;  ///< effective requirements
  UserValues user;
  std::vector<Alternative> lower;
  std::uint32_t component = kNoComponent;
  std::optional<std::uint32_t> mesh_node;    ///< on a mesh: index into its nodes; none: any of them
  std::uint32_t program_rule = kAnyProgram;  ///< on a gateway: see System::program_rules
  Origin origin;
};

/// What an end states in its channel's attribute set of that number (0: the preferred one). An end
/// that was admitted at run time may state one set, which counts in all.
template <class End>
[[nodiscard]] const AttributeSet& attributes_in(const End& end, std::size_t set) {
  return set == 0 || set > end.lower.size() ? end.attributes : end.lower[set - 1].attributes;
}
template <class End>
[[nodiscard]] const UserValues& user_values_in(const End& end, std::size_t set) {
  return set == 0 || set > end.lower.size() ? end.user : end.lower[set - 1].user;
}

/// A device or program with the ends that it brings along.
struct Component {
  std::string name;
  std::string description;
  Place place;
  Origin origin;
};

/// The declared way between two places, in both directions. Where one is declared, no other is
/// searched for.
struct DeclaredRoute {
  std::vector<Place> places;  ///< both ends included; networks and gateways alternate
  Origin origin;
};

struct System {
  std::string name;
  std::vector<std::string> files;  ///< what was read: the description, then what it includes
  std::vector<UserAttribute> user_attributes;
  std::vector<EventChannel> channels;
  std::vector<Network> networks;
  std::vector<Gateway> gateways;
  std::vector<Component> components;
  std::vector<DeclaredRoute> routes;
  std::vector<Publisher> publishers;
  std::vector<Subscriber> subscribers;
  std::vector<ProgramRule> program_rules;  ///< that ends state, each once

  /// What a program must be; nullptr: nothing beside its user.
  [[nodiscard]] const ProgramRule* program_rule(std::uint32_t number) const {
    return number < program_rules.size() ? &program_rules[number] : nullptr;
  }

  /// What capacity is held of: each network, then each gateway.
  [[nodiscard]] std::size_t resources() const { return networks.size() + gateways.size(); }
  [[nodiscard]] std::size_t resource_of(Place place) const {
    return place.kind == Place::Kind::network ? place.index : networks.size() + place.index;
  }
  [[nodiscard]] const AttributeSet& provision_of(Place place) const {
    return place.kind == Place::Kind::network ? networks[place.index].provision
                                              : gateways[place.index].provision;
  }

  /// So that Network::binding_of() finds them; every decision needs it.
  void sort_bindings() {
    for (Network& network : networks) std::ranges::sort(network.bindings, {}, &Binding::channel);
  }
};

/// By network: several ports lead there, mostly those of several gateways.
[[nodiscard]] inline std::vector<bool> shared_networks(const System& system) {
  std::vector<std::size_t> ports(system.networks.size(), 0);
  for (const Gateway& gateway : system.gateways)
    for (const Port& port : gateway.ports) ++ports[port.network];
  std::vector<bool> shared;
  shared.reserve(ports.size());
  for (const std::size_t count : ports) shared.push_back(count > 1);
  return shared;
}

}  // namespace mlcca::core
