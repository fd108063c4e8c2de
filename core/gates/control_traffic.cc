// SPDX-License-Identifier: BSD-2-Clause
#include "core/gates/control_traffic.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/model/medium.hpp"
#include "core/model/progress.hpp"

namespace mlcca::core {
namespace {

/// Whether a binding has exactly this identifier. Frames of a binding within a wider range have
/// slots of their own.
bool is_bound(const Network& network, const ControlFrames& frames) {
  return std::ranges::any_of(network.bindings, [&](const Binding& b) {
    Progress::step();
    Publisher any;
    any.node = 0;
    const auto bound = identity_of(any, network, b, false);
    const std::uint32_t number = traits_of(network.profile).number_bits;
    return bound && (frames.identity.mask & number) == number &&
           ((bound->id ^ frames.identity.id) & number) == 0;
  });
}

/// The frames with the tag of kSubscribeSubject filled in.
ControlFrames tagged(ControlFrames frames, const Network& network) {
  frames.identity.id |= network.subscribe_tag;
  frames.identity.mask |= traits_of(network.profile).last;
  return frames;
}

/// Whether (id, mask) is `open`, an identity without a tag, with any valid tag filled in.
bool is_tagged_identity(const ProfileTraits& traits, const FrameIdentity& open, std::uint32_t id,
                        std::uint32_t mask) {
  return (id & ~traits.last) == open.id && mask == (open.mask | traits.last) &&
         (id & traits.last) >= traits.first;
}

/// Whether the tag of kSubscribeSubject is known and not used by a channel.
bool has_own_tag(const Network& network) {
  return network.subscribe_tag != 0 && std::ranges::find(network.bindings, network.subscribe_tag,
                                                         &Binding::id) == network.bindings.end();
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
  /// Adds another user who may send the frames that were added last.
  void add_sender(std::uint32_t uid) {
    rules_.push_back(rules_.back());
    rules_.back().entry.uid = uid;
  }
  /// Adds the rules for a network whose datagrams carry the subject.
  void add_datagrams(std::size_t port, const ControlKind& kind, const ControlState& state,
                     const Port& at, const Network& network) {
    const std::size_t first = rules_.size();
    ControlFrames frames = kind.frames.front();
    if (network.subscriptions.accept != Subscribing::nobody)
      frames.max_length = subscription_bytes(network);
    add(port, frames, kind, state, at);
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

std::uint16_t subscription_bytes(const Network& network) {
  return static_cast<std::uint16_t>(std::min<Value>(kSubscriptionBytes, event_bytes(network)));
}

std::span<const ControlKind> control_kinds(Profile profile) { return traits_of(profile).control; }

std::span<const ControlKind> control_kinds(const Network& network) {
  const ProfileTraits& traits = traits_of(network.profile);
  return network.kind == NetworkKind::can ? traits.control : traits.datagram_control;
}

std::string_view control_kind_of(Profile profile, std::uint32_t id, std::uint32_t mask) {
  const ProfileTraits& traits = traits_of(profile);
  const std::uint32_t whole = mask & ~kRemoteFlag;
  for (const ControlKind& kind : traits.control)
    for (const ControlFrames& frames : kind.frames)
      if (frames.identity == FrameIdentity{.id = id, .mask = whole} ||
          (kind.is_tagged && is_tagged_identity(traits, frames.identity, id, whole)))
        return kind.name;
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

/// Adds the rules of one kind at a CAN port. `asker`: user ID that asks the broker for tags, if
/// any.
void add_can_frames(ControlRules& rules, std::size_t p, const Port& port, const Network& network,
                    std::size_t kind, std::optional<std::uint32_t> asker) {
  const ControlKind& known = control_kinds(network)[kind];
  const ControlState state = control_at(network, port, kind);
  if (known.is_tagged && !has_own_tag(network)) return;
  for (const ControlFrames& open : known.frames) {
    if (open.of_subscriptions && network.subscriptions.accept == Subscribing::nobody) continue;
    const ControlFrames frames = known.is_tagged ? tagged(open, network) : open;
    if (is_bound(network, frames)) continue;
    rules.add(p, frames, known, state, port);
    if (asker && port.node && *asker != port.control_uid && frames.asks_for_tag)
      rules.add_sender(*asker);
  }
}

}  // namespace

std::optional<FrameIdentity> subscription_frames(const Network& network, const Port& port) {
  if (!has_broker(network) || !has_own_tag(network) || !port.node) return std::nullopt;
  const ProfileTraits& traits = traits_of(network.profile);
  for (const ControlKind& kind : traits.control)
    if (kind.is_tagged) {
      // The identifiers of fragments differ in one bit, which is left open here.
      const FrameIdentity whole = tagged(kind.frames.front(), network).identity;
      const FrameIdentity fragments = tagged(kind.frames.back(), network).identity;
      Publisher self;
      self.node = port.node;
      self.priority = kSubscriptionPriority;
      Binding binding;
      binding.id = network.subscribe_tag;
      binding.extended = true;
      return FrameIdentity{.id = identity_of(self, network, binding, false)->id,
                           .mask = whole.mask & ~(whole.id ^ fragments.id)};
    }
  return std::nullopt;
}

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
        rules.add_datagrams(p, kinds[k], control_at(network, ports[p], k), ports[p], network);
    }
  }
  return rules.take();
}

}  // namespace mlcca::core
