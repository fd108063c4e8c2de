// SPDX-License-Identifier: BSD-2-Clause
// The described world as plain structs: the output of description/ and the input of every decision.
// Things refer to each other by index. There is no behaviour here other than look-ups.
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

/// A user-defined attribute that the description adds to the built-in ones of mlcca/attribute.hpp.
struct UserAttribute {
  std::string name;
  Better better = Better::smaller;
  Composition composition = Composition::sum;  ///< sum, slowest, smallest or survival
  std::string unit;                            ///< as text: "K", "m s^-1"; empty for a plain number
  int magnitude = 0;  ///< a value is a multiple of 10^magnitude of the unit
  Origin origin;
};

/// The value of a user-defined attribute.
struct UserValue {
  std::uint32_t attribute = 0;  ///< index into System::user_attributes
  bool dynamic = false;         ///< provided as a best case only
  Value value = 0;
  bool operator==(const UserValue&) const = default;
};
/// Sorted by attribute; each attribute occurs at most once.
using UserValues = std::vector<UserValue>;

/// One of several attribute sets of a channel, or of one of its ends.
struct Alternative {
  std::int32_t priority = 0;  ///< larger is preferred
  AttributeSet attributes;
  UserValues user;
};

/// The safe side of a subject: whether it is safe or dangerous if its events are dropped.
enum class SafeSide : std::uint8_t {
  unstated,
  drop,     ///< to drop is safe: the receiver of a heart-beat reacts to silence
  deliver,  ///< to drop is dangerous: the message must arrive to stop something
};

/// When the events of a channel come. Its Period bounds both kinds.
enum class Arrival : std::uint8_t {
  periodic,  ///< one in each Period: if none comes, events are missing
  sporadic,  ///< when something happens, Periods apart or longer: silence means nothing
};

/// The largest number of hops (networks and gateways) of a route. Longer routes are not found.
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

/// The CAN frame formats that a binding allows; `any` means classic and FD.
enum class FrameFormat : std::uint8_t { classic, fd, any, xl };

/// What a channel's subject is called on one network, in the terms of the network's profile.
struct Binding {
  std::size_t channel = 0;  ///< index into System::channels
  std::uint32_t id = 0;     ///< identifier (raw), etag, PGN, subject-id or COB-ID
  /// famouso: the broker assigns the etag at run time. Until it is known `id` is 0.
  bool dynamic = false;
  bool extended = false;  ///< 29-bit identifiers; raw: as stated, otherwise as the profile requires
  FrameFormat format = FrameFormat::classic;
  bool remote_frames = false;               ///< whether RTR frames are part of the channel
  std::optional<std::uint8_t> priority;     ///< j1939, cyphal: 0 (highest) to 7; nullopt: any
  std::optional<std::uint8_t> destination;  ///< j1939, PDU1: destination address; nullopt: any
  std::uint32_t mask = 0x1fffffff;          ///< raw: the bits of the identifier that are compared
  Origin origin;

  /// Whether the broker has not assigned the etag yet, so that no frame can carry it.
  [[nodiscard]] bool waits_for_tag() const { return dynamic && id == 0; }
  /// Whether it stands for a range of identifiers.
  [[nodiscard]] bool is_masked() const {
    const std::uint32_t whole = extended ? 0x1fffffff : 0x7ff;
    return (mask & whole) != whole;
  }
};

/// The errors on a bus that are to be expected: at most `count` in any `interval` (ns). A count of
/// 0 means none.
struct FaultHypothesis {
  std::uint32_t count = 0;
  Value interval = 0;
  bool operator==(const FaultHypothesis&) const = default;
};

/// What the description states about a CAN bus beside the admitted channels.
struct CanBus {
  std::uint32_t bitrate = 0;       ///< bit/s, 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s of the FD data phase, 0: classic frames only
  bool unknown_senders = false;  ///< whether stations that are not described may send, so that any
                                 ///< frame may block
  std::uint32_t background = 0;  ///< bus time that others take at any priority, in 1e-6
  bool measured = true;  ///< whether measured load above the admitted one counts as unaccounted
                         ///< load
  FaultHypothesis faults;
  bool operator==(const CanBus&) const = default;
};

/// Which control traffic of a profile (core/gates/control_traffic.hpp) passes a gate.
struct ControlPolicy {
  std::optional<std::uint32_t> kinds;  ///< one bit per kind, in their order; nullopt: the profile's
                                       ///< default
  std::uint32_t rate = 0;              ///< frames/s of each kind; 0: the default of the kind
  bool operator==(const ControlPolicy&) const = default;
};

/// Which channels may be admitted onto a network at run time although they are not described.
struct UnlistedPolicy {
  bool allowed = false;
  Subject subject = 0;  ///< a channel qualifies if its first `bits` bits are those of this subject
  std::uint8_t bits = 0;    ///< 0: every subject
  std::uint32_t most = 16;  ///< the most such channels at the same time, 1 to 256

  /// `subject` with all bits cleared that are not compared.
  [[nodiscard]] Subject leading() const {
    return bits == 0 ? 0 : subject >> (64U - bits) << (64U - bits);
  }
  /// Whether a channel with that subject may be admitted.
  [[nodiscard]] bool admits(Subject s) const {
    return allowed && (bits == 0 || (s ^ subject) >> (64U - bits) == 0);
  }
};

/// Whose subscriptions are accepted that arrive over a FAMOUSO network, under its subject SUBSCRIB.
enum class Subscribing : std::uint8_t {
  nobody,
  gateways,         ///< nobody's; gateways only announce their presence there
  with_attributes,  ///< those that state their requirements
  all,              ///< also those of plain FAMOUSO nodes, which require what the channel states
};
/// Which subscriptions that arrive over a network are accepted.
struct SubscriptionPolicy {
  Subscribing accept = Subscribing::nobody;
  std::uint32_t most = 64;  ///< the most subscriptions over this network at the same time, 1 to
                            ///< 1024
  Origin origin;
};

/// One medium with all that the description states about it.
struct Network {
  std::string name;
  NetworkKind kind = NetworkKind::can;
  Profile profile = Profile::none;
  CanBus bus;  ///< for a CAN network
  ControlPolicy control;
  /// For a FAMOUSO bus: the etag of the subject SUBSCRIB, under which all nodes of the bus
  /// subscribe; 0: not known. `states_subscribe_tag`: the description states it.
  std::uint32_t subscribe_tag = 0;
  bool states_subscribe_tag = false;
  UnlistedPolicy unlisted;
  SubscriptionPolicy subscriptions;
  std::optional<mesh::Mesh> mesh;  ///< for a mesh whose routes are evaluated
  AttributeSet provision;          ///< static provision; a dynamic mark makes it a best case
  UserValues user;
  std::vector<Binding> bindings;  ///< sorted by channel, see sort_bindings()
  Origin origin;

  /// Whether frames carry the 64-bit subject itself, as on Ethernet-like networks. Such a network
  /// has no bindings.
  [[nodiscard]] bool carries_subjects() const;
  /// The binding of a channel, or null. Requires that `bindings` is sorted by channel.
  [[nodiscard]] const Binding* binding_of(std::size_t channel) const {
    const auto it = std::ranges::lower_bound(bindings, channel, {}, &Binding::channel);
    return it != bindings.end() && it->channel == channel ? &*it : nullptr;
  }
};

/// By what an interface is recognised. Each part that is stated must match.
struct InterfaceIdentity {
  std::string name;              ///< kernel name
  std::string id_path;           ///< udev ID_PATH
  std::string serial;            ///< udev ID_SERIAL_SHORT
  std::string alias;             ///< ifalias
  std::optional<unsigned> port;  ///< dev_port or dev_id, for adapters with several channels

  auto operator<=>(const InterfaceIdentity&) const = default;
};

/// In which order the frames of a gateway wait for the bus.
enum class Queueing : std::uint8_t {
  fifo,      ///< in the order of their arrival, the default of Linux
  priority,  ///< the frame that wins arbitration first; mlccad configures the queueing discipline
             ///< for it
};

/// What happens to excess frames, which exceed the admitted traffic.
enum class Excess : std::uint8_t {
  drop,
  pass,  ///< they are counted and pass
};

/// The result that a program gets from its system call when the gate drops its frame at egress.
enum class Refused : std::uint8_t {
  error,   ///< ENOBUFS, as for a full queue
  silent,  ///< success, for programs that would end at the first error
};

/// Who carries admitted events from one network of a gateway to another.
enum class Forwarder : std::uint8_t {
  relay,   ///< between CAN buses can-gw, with rules of mlccad; otherwise mlcca-relay
  can_gw,  ///< between CAN buses can-gw as above; otherwise the kernel or the `sender` of a port
  none,    ///< like can_gw, but mlccad makes no rules
};

/// The connection of a gateway to one network by one interface.
struct Port {
  std::size_t network = 0;
  InterfaceIdentity identity;
  bool managed = false;            ///< mlccad sets the bit rates and brings the interface up
  std::uint32_t bitrate = 0;       ///< bit/s; 0: mlccad does not set it
  std::uint32_t data_bitrate = 0;  ///< bit/s of the FD data phase, 0: classic only
  Queueing queueing = Queueing::fifo;
  std::uint32_t fifo_depth = 1;     ///< frames that the controller holds behind the queue, 1 to 64
  std::uint32_t queue_length = 10;  ///< frames that the queue holds before one is lost, 1 to 10000
  Excess excess = Excess::drop;
  Refused refused = Refused::error;
  ControlPolicy control;          ///< takes precedence over that of the network
  std::uint32_t control_uid = 0;  ///< user ID of the programs that may send control traffic
  /// The FAMOUSO node number of this gateway on its bus, with which it asks the broker for tags.
  std::optional<std::uint8_t> node;
  /// User ID of a program that sends here, in place of mlcca-relay, what the kernel does not carry.
  std::optional<std::uint32_t> sender;
  Origin origin;
};

/// A host that joins networks. It is a hop of a route too: forwarding has a provision of its own.
struct Gateway {
  std::string name;
  std::string host;  ///< host name of the machine; empty: not stated
  AttributeSet provision;
  UserValues user;
  Forwarder forwarder = Forwarder::relay;
  /// The interval, in ns, in which the gateway announces its presence on its networks, so that
  /// another gateway takes over when it fails; 0: it does not announce itself.
  Value presence = 0;
  std::optional<std::uint32_t> relay;  ///< user ID of mlcca-relay; nullopt: the machine has none
  std::vector<Port> ports;
  Origin origin;

  /// The port of this gateway on a network; null if it has none.
  [[nodiscard]] const Port* port_on(std::size_t network) const {
    for (const auto& p : ports)
      if (p.network == network) return &p;
    return nullptr;
  }
};

/// A subject with the attributes that its communication requires.
struct EventChannel {
  std::string name;  ///< short name; unique
  Subject subject = 0;
  std::string description;
  SafeSide safe_side = SafeSide::unstated;
  Arrival arrival = Arrival::periodic;
  std::uint8_t importance = 0;  ///< channels of larger importance are degraded last and served
                                ///< first
  AttributeSet attributes;      ///< defaults for the channel's endpoints
  UserValues user;
  std::int32_t priority = 0;       ///< of `attributes`, where there are further sets
  std::vector<Alternative> lower;  ///< the further attribute sets, by falling priority
  /// The channel is not described: it was admitted at run time, or it is an unnamed entry that is
  /// free for such an admission.
  bool unlisted = false;
  Origin origin;
};

/// Where an endpoint is: on a network (any node of it), or on a gateway (a program of that host).
struct Place {
  enum class Kind : std::uint8_t { network, gateway };
  Kind kind = Kind::network;
  std::size_t index = 0;
  auto operator<=>(const Place&) const = default;
};

/// Value of `component` for an endpoint that belongs to no component.
inline constexpr std::uint32_t kNoComponent = 0xffffffff;

/// What a program on a gateway must fulfil to take up an endpoint. All stated parts must hold, in
/// addition to the user ID that a publisher states.
struct ProgramRule {
  std::optional<std::uint32_t> gid;  ///< group that the program must be in
  std::string group;                 ///< the group as it was stated
  std::string unit;                  ///< systemd unit in which it must run; empty: any
  bool operator==(const ProgramRule&) const = default;
};
/// Value of `program_rule` for an endpoint that states no rule.
inline constexpr std::uint32_t kAnyProgram = 0xffffffff;

/// An endpoint that sends events of a channel.
struct Publisher {
  std::string name;
  std::size_t channel = 0;
  Place place;
  AttributeSet attributes;  ///< effective values: Period, MaxPayload, Jitter and Bandwidth are its
                            ///< traffic, the others its own requirements
  UserValues user;
  std::vector<Alternative> lower;  ///< its attributes in each further set of the channel
  std::uint32_t component = kNoComponent;
  std::optional<std::uint8_t> node;        ///< its node number where the profile has one
  std::optional<std::uint32_t> mesh_node;  ///< on a mesh: index of its node; nullopt: any
  Station station;                   ///< source address of its frames, where frames carry subjects
  std::uint8_t priority = 0x7d;      ///< famouso: 0 (highest) to 127
  std::optional<std::uint32_t> uid;  ///< on a gateway: user ID that may send
  std::uint32_t program_rule = kAnyProgram;  ///< on a gateway: index into System::program_rules
  Origin origin;
};

/// An endpoint that receives events of a channel.
struct Subscriber {
  std::string name;
  std::size_t channel = 0;
  Place place;
  AttributeSet attributes;  ///< effective requirements
  UserValues user;
  std::vector<Alternative> lower;
  std::uint32_t component = kNoComponent;
  std::optional<std::uint32_t> mesh_node;    ///< on a mesh: index of its node; nullopt: any
  std::uint32_t program_rule = kAnyProgram;  ///< on a gateway: index into System::program_rules
  Origin origin;
};

/// What an endpoint states for the channel's attribute set of that number (0: the preferred one).
/// An endpoint that was admitted at run time may state a single set, which then counts for all.
template <class End>
[[nodiscard]] const AttributeSet& attributes_in(const End& end, std::size_t set) {
  return set == 0 || set > end.lower.size() ? end.attributes : end.lower[set - 1].attributes;
}
template <class End>
[[nodiscard]] const UserValues& user_values_in(const End& end, std::size_t set) {
  return set == 0 || set > end.lower.size() ? end.user : end.lower[set - 1].user;
}

/// A device or program to which several endpoints belong.
struct Component {
  std::string name;
  std::string description;
  Place place;
  Origin origin;
};

/// A declared route between two places, valid in both directions. Between these two places no other
/// route is used.
struct DeclaredRoute {
  std::vector<Place> places;  ///< both ends included; networks and gateways alternate
  Origin origin;
};

/// The complete description of networks, gateways and channels.
struct System {
  std::string name;
  std::vector<std::string> files;  ///< files that were read: the description, then those that it
                                   ///< includes
  std::vector<UserAttribute> user_attributes;
  std::vector<EventChannel> channels;
  std::vector<Network> networks;
  std::vector<Gateway> gateways;
  std::vector<Component> components;
  std::vector<DeclaredRoute> routes;
  std::vector<Publisher> publishers;
  std::vector<Subscriber> subscribers;
  std::vector<ProgramRule> program_rules;  ///< the rules that endpoints state, without duplicates

  /// The rule of that index; null if there is none, so that only the user ID counts.
  [[nodiscard]] const ProgramRule* program_rule(std::uint32_t number) const {
    return number < program_rules.size() ? &program_rules[number] : nullptr;
  }

  /// Resources are what capacity is reserved on: first each network, then each gateway.
  [[nodiscard]] std::size_t resources() const { return networks.size() + gateways.size(); }
  [[nodiscard]] std::size_t resource_of(Place place) const {
    return place.kind == Place::Kind::network ? place.index : networks.size() + place.index;
  }
  [[nodiscard]] const AttributeSet& provision_of(Place place) const {
    return place.kind == Place::Kind::network ? networks[place.index].provision
                                              : gateways[place.index].provision;
  }

  /// Sorts the bindings of all networks by channel. Network::binding_of() and with it every
  /// decision needs that.
  void sort_bindings() {
    for (Network& network : networks) std::ranges::sort(network.bindings, {}, &Binding::channel);
  }
};

/// For each network whether more than one port leads to it, as a rule those of several gateways.
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
