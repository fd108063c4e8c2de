// SPDX-License-Identifier: BSD-2-Clause
#include "core/gates/control_traffic.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/model/medium.hpp"
#include "core/model/progress.hpp"

namespace mlcca::core {
namespace {

constexpr ControlFrames extended(std::uint32_t id, std::uint32_t open, std::uint16_t bytes = 8) {
  return {{.id = kExtendedFlag | id, .mask = kExtendedFlag | (kExtendedBits & ~open)}, bytes};
}
constexpr ControlFrames standard(std::uint32_t id, std::uint32_t open, std::uint16_t bytes) {
  return {{.id = id, .mask = kExtendedFlag | (kExtendedBits & ~open)}, bytes};
}

// FAMOUSO: all with priority 0x7d. The request of a stage has stage and nibble where the node and
// the fragment bit are; its answer keeps the top bit of the stage. Tags are given by node 0x7f.
constexpr std::uint32_t kNode = 0x1fc000;
constexpr std::uint32_t kStage = 0x3fc000;
constexpr std::array kConfiguration = {extended(0x1f400000, kStage),
                                       extended(0x1f400001, kStage, 0)};
constexpr std::array kBinding = {extended(0x1f400002, kNode), extended(0x1f5fc004, 0)};
constexpr std::uint32_t kTag = 0x3fff;
constexpr std::array kSubscribe = {extended(0x1f400000, kNode | kTag)};
// A node subscribes all its channels at once when it starts.
constexpr ControlKind kSubscribing{
    .name = "subscribe", .frames = kSubscribe, .rate = 100, .burst = 100, .is_tagged = true};
constexpr std::array kFamouso = {
    ControlKind{.name = "configuration", .frames = kConfiguration, .rate = 200, .burst = 32},
    ControlKind{.name = "binding", .frames = kBinding, .rate = 200, .burst = 32}, kSubscribing};
// Where frames carry the subject itself, nothing is configured or bound.
constexpr std::array kFamousoDatagrams = {kSubscribing};

// SAE J1939-81 (address claim), J1939-21 (request, acknowledgement, transport), ISO 11783-3
// (extended transport). Priorities and, where there are some, destinations are open. An address
// claim goes to all nodes, and may come from the null address too.
constexpr std::uint32_t kPriority = 0x1c000000;
constexpr std::uint32_t kSource = 0xff;
constexpr std::uint32_t kAnyTwo = kPriority | 0xff00 | kSource;
constexpr std::array kAddressClaim = {extended(0x00eeff00, kPriority | kSource)};
constexpr std::array kRequest = {extended(0x00ea0000, kAnyTwo)};
constexpr std::array kAcknowledgement = {extended(0x00e80000, kAnyTwo)};
constexpr std::array kTransport = {extended(0x00ec0000, kAnyTwo), extended(0x00eb0000, kAnyTwo)};
constexpr std::array kExtendedTransport = {extended(0x00c80000, kAnyTwo),
                                           extended(0x00c70000, kAnyTwo)};
constexpr std::array kJ1939 = {
    ControlKind{.name = "address-claim", .frames = kAddressClaim, .rate = 50, .burst = 256},
    ControlKind{.name = "request", .frames = kRequest, .rate = 100, .burst = 20},
    ControlKind{.name = "acknowledgement", .frames = kAcknowledgement, .rate = 100, .burst = 20},
    ControlKind{
        .name = "transport", .frames = kTransport, .rate = 500, .burst = 300, .is_carrier = true},
    ControlKind{.name = "extended-transport",
                .frames = kExtendedTransport,
                .rate = 500,
                .burst = 300,
                .is_carrier = true}};

// Cyphal Specification v1.0, 5.3: heartbeat (7509) of every node once a second, and the allocation
// of node-ids (8165, 8166), asked for anonymously. Services (GetInfo too) are no messages.
constexpr std::uint32_t kAnyNode = kPriority | 0x600000 | 0x7f;
constexpr std::uint32_t kAnonymous = 0x1000000;
constexpr std::array kHeartbeat = {extended(7509U << 8, kAnyNode)};
constexpr std::array kAllocation = {extended(8165U << 8, kAnyNode | kAnonymous, 64),
                                    extended(8166U << 8, kAnyNode | kAnonymous)};
constexpr std::array kCyphal = {
    ControlKind{.name = "heartbeat", .frames = kHeartbeat, .rate = 200, .burst = 128},
    ControlKind{.name = "allocation", .frames = kAllocation, .rate = 20, .burst = 10}};

// CiA 301 v4.2, table 39.
constexpr std::uint32_t kNodeId = 0x7f;
constexpr std::array kNmt = {standard(0x000, 0, 2)};
constexpr std::array kSync = {standard(0x080, 0, 1)};
constexpr std::array kEmergency = {standard(0x080, kNodeId, 8)};
constexpr std::array kTime = {standard(0x100, 0, 6)};
constexpr std::array kErrorControl = {standard(0x700, kNodeId, 1)};
constexpr std::array kCanopen = {
    ControlKind{.name = "nmt", .frames = kNmt, .rate = 50, .burst = 10},
    ControlKind{.name = "sync", .frames = kSync, .rate = 1000, .burst = 2},
    ControlKind{.name = "emergency", .frames = kEmergency, .rate = 200, .burst = 127},
    ControlKind{.name = "time", .frames = kTime, .rate = 10, .burst = 2},
    ControlKind{.name = "error-control", .frames = kErrorControl, .rate = 1500, .burst = 127}};

/// A binding has exactly this number. Frames of a binding within a wider range are distinguished by
/// its own slots.
bool is_bound(const Network& network, const ControlFrames& frames) {
  return std::ranges::any_of(network.bindings, [&](const Binding& b) {
    Progress::step();
    Publisher any;
    any.node = 0;
    const auto bound = identity_of(any, network, b, false);
    constexpr std::uint32_t j1939_number = 0x03ff0000;
    constexpr std::uint32_t cyphal_number = 0x001fff00;
    std::uint32_t number = kExtendedFlag | kExtendedBits;
    if (network.profile == Profile::j1939) number = j1939_number;
    if (network.profile == Profile::cyphal) number = cyphal_number;
    return bound && (frames.identity.mask & number) == number &&
           ((bound->id ^ frames.identity.id) & number) == 0;
  });
}

/// The tag of kSubscribeSubject in its place.
constexpr ControlFrames tagged(ControlFrames frames, std::uint32_t tag) {
  frames.identity.id |= tag;
  frames.identity.mask |= kTag;
  return frames;
}

constexpr bool is_tagged_identity(std::uint32_t id, std::uint32_t mask) {
  const FrameIdentity& open = kSubscribe.front().identity;
  return (id & ~kTag) == open.id && mask == (open.mask | kTag) &&
         (id & kTag) >= traits_of(Profile::famouso).first;
}

/// The tag of kSubscribeSubject is known, and no channel's.
bool has_own_tag(const Network& network) {
  return network.subscribe_tag != 0 && std::ranges::find(network.bindings, network.subscribe_tag,
                                                         &Binding::id) == network.bindings.end();
}

bool asks_for_tag(const ControlFrames& frames) {
  return frames.identity == kBinding.front().identity;
}

class ControlRules {
 public:
  void add(std::size_t port, const ControlFrames& frames, const ControlKind& kind,
           const ControlState& state, const Port& at) {
    constexpr Value second = 1'000'000'000;
    const Value per_frame = second / state.rate;
    GateRule rule;
    rule.entry.port = port;
    rule.entry.id = frames.identity.id;
    rule.entry.mask = frames.identity.mask | kRemoteFlag;
    rule.entry.max_length = frames.max_length;
    rule.entry.classic = true;
    rule.entry.fd = frames.max_length > kClassicBytes;
    rule.entry.subject = kControlSubject;
    rule.pass = state.allowed;
    rule.policing = {.per_frame = per_frame,
                     .per_byte = 0,
                     .tolerance = per_frame * kind.burst,
                     .counts_only = at.excess == Excess::pass};
    rules_.push_back(rule);
    rule.entry.direction = Direction::egress;
    rule.entry.uid = at.control_uid;
    rules_.push_back(rule);
    if (!kind.is_carrier) return;
    rule.entry.uid = 0;
    rule.entry.from_kernel = true;
    rules_.push_back(rule);
  }
  /// Who may send the frames that were added last, too.
  void add_sender(std::uint32_t uid) {
    rules_.push_back(rules_.back());
    rules_.back().entry.uid = uid;
  }
  /// Where datagrams carry the subject.
  void add_datagrams(std::size_t port, const ControlKind& kind, const ControlState& state,
                     const Port& at) {
    const std::size_t first = rules_.size();
    add(port, kind.frames.front(), kind, state, at);
    for (std::size_t i = first; i < rules_.size(); ++i) {
      GateEntry& entry = rules_[i].entry;
      entry.id = entry.mask = 0;
      entry.classic = false;
      entry.subject = kSubscribeSubject;
    }
  }
  [[nodiscard]] GateState take() {
    std::ranges::sort(rules_, {}, &GateRule::entry);
    return std::move(rules_);
  }

 private:
  GateState rules_;
};

}  // namespace

std::span<const ControlKind> control_kinds(Profile profile) {
  switch (profile) {
    case Profile::famouso:
      return kFamouso;
    case Profile::j1939:
      return kJ1939;
    case Profile::cyphal:
      return kCyphal;
    case Profile::canopen:
      return kCanopen;
    default:
      return {};
  }
}

std::span<const ControlKind> control_kinds(const Network& network) {
  if (network.kind == NetworkKind::can) return control_kinds(network.profile);
  return network.carries_subjects() ? std::span<const ControlKind>(kFamousoDatagrams)
                                    : std::span<const ControlKind>();
}

std::string_view control_kind_of(Profile profile, std::uint32_t id, std::uint32_t mask) {
  for (const ControlKind& kind : control_kinds(profile))
    for (const ControlFrames& frames : kind.frames)
      if (frames.identity.id == id && frames.identity.mask == (mask & ~kRemoteFlag))
        return kind.name;
  if (profile == Profile::famouso && is_tagged_identity(id, mask & ~kRemoteFlag))
    return kSubscribing.name;
  return {};
}

ControlState control_at(const Network& network, const Port& port, std::size_t kind) {
  const auto allowed = port.control.kinds ? port.control.kinds : network.control.kinds;
  const std::uint32_t rate = port.control.rate != 0 ? port.control.rate : network.control.rate;
  const ControlKind& known = control_kinds(network)[kind];
  return {.allowed = allowed ? (*allowed >> kind & 1U) != 0 : !known.is_carrier,
          .rate = rate != 0 ? rate : known.rate};
}

namespace {

/// What one kind needs on a CAN port. `asker`: who asks the broker for tags, if anyone does.
void add_can_frames(ControlRules& rules, std::size_t p, const Port& port, const Network& network,
                    std::size_t kind, std::optional<std::uint32_t> asker) {
  const ControlKind& known = control_kinds(network)[kind];
  const ControlState state = control_at(network, port, kind);
  if (known.is_tagged && !has_own_tag(network)) return;
  for (const ControlFrames& open : known.frames) {
    const ControlFrames frames = known.is_tagged ? tagged(open, network.subscribe_tag) : open;
    if (is_bound(network, frames)) continue;
    rules.add(p, frames, known, state, port);
    if (asker && port.node && *asker != port.control_uid && asks_for_tag(frames))
      rules.add_sender(*asker);
  }
}

}  // namespace

GateState control_rules(const System& system, std::size_t gateway,
                        std::optional<std::uint32_t> asker) {
  ControlRules rules;
  const auto& ports = system.gateways[gateway].ports;
  const bool is_channel = std::ranges::find(system.channels, kSubscribeSubject,
                                            &EventChannel::subject) != system.channels.end();
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const Network& network = system.networks[ports[p].network];
    const auto kinds = control_kinds(network);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      if (kinds[k].is_tagged && is_channel) continue;
      if (network.kind == NetworkKind::can)
        add_can_frames(rules, p, ports[p], network, k, asker);
      else
        rules.add_datagrams(p, kinds[k], control_at(network, ports[p], k), ports[p]);
    }
  }
  return rules.take();
}

}  // namespace mlcca::core
