// SPDX-License-Identifier: BSD-2-Clause
// Control traffic: what a profile needs beside its channels, such as address claims, bindings and
// node states. It belongs to no channel, stays on its bus and is limited to a rate.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/gates/plan.hpp"
#include "core/model/system.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {

/// Payload bytes of the longest subscription message on a network that carries subjects.
[[nodiscard]] std::uint16_t subscription_bytes(const Network& network);

/// The subject of slots for control traffic. No channel has it.
inline constexpr Subject kControlSubject = 0;

/// "SUBSCRIB": the subject of events with which FAMOUSO nodes announce their subscriptions to
/// FAMOUSO gateways; the 8 bytes of payload are the subscribed subject. A described channel with
/// this subject takes precedence.
inline constexpr Subject kSubscribeSubject = 0x5355425343524942;

/// The kinds of control traffic of a CAN network with that profile, in the order of
/// ControlPolicy::kinds.
[[nodiscard]] std::span<const ControlKind> control_kinds(Profile profile);
/// The kinds of control traffic of a network.
[[nodiscard]] std::span<const ControlKind> control_kinds(const Network& network);

/// The name of the kind of control traffic to which frames of this identity belong on a CAN
/// network; empty if there is none.
[[nodiscard]] std::string_view control_kind_of(Profile profile, std::uint32_t id,
                                               std::uint32_t mask);

/// Whether a kind passes at a port, and its limit in frames/s.
struct ControlState {
  bool allowed = true;
  std::uint32_t rate = 0;
};
[[nodiscard]] ControlState control_at(const Network& network, const Port& port, std::size_t kind);

/// The identifier of the subscription frames that the gateway sends at that port, with the mask by
/// which it receives those of others. Nullopt if the tag of kSubscribeSubject is unknown or the
/// port states no node number.
[[nodiscard]] std::optional<FrameIdentity> subscription_frames(const Network& network,
                                                               const Port& port);

/// The rules for all control traffic of one gateway, sorted by entry. A kind that is switched off
/// has rules that refuse. An identifier that a Binding assigns to a channel belongs to that channel
/// alone. There are no rules for kSubscribeSubject if its tag is unknown. `asker`: user ID that
/// asks the broker for tags as the node of a Port, in addition to its control_uid.
[[nodiscard]] GateState control_rules(const System& system, std::size_t gateway,
                                      std::optional<std::uint32_t> asker = {});

}  // namespace mlcca::core
