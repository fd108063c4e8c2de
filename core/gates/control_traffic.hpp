// SPDX-License-Identifier: BSD-2-Clause
// What a profile needs beside its channels: addresses, bindings, node states. It is no channel's,
// stays on its bus, and is limited to a rate.
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

/// The longest message about subscriptions on a network that carries subjects.
[[nodiscard]] std::uint16_t subscription_bytes(const Network& network);

/// Subject of the slots of control traffic: no channel has it.
inline constexpr Subject kControlSubject = 0;

/// "SUBSCRIB": by an event of it, whose 8 bytes are a subject, a FAMOUSO node announces to gateways
/// of its own kind what it subscribes. A channel that a description gives this subject takes its
/// place.
inline constexpr Subject kSubscribeSubject = 0x5355425343524942;

/// Of a CAN network of that profile, in the order of ControlPolicy::kinds.
[[nodiscard]] std::span<const ControlKind> control_kinds(Profile profile);
/// Of any network.
[[nodiscard]] std::span<const ControlKind> control_kinds(const Network& network);

/// The kind that frames of this identity are of on a CAN network, by name; empty: none.
[[nodiscard]] std::string_view control_kind_of(Profile profile, std::uint32_t id,
                                               std::uint32_t mask);

/// Whether the kind passes at the port, and its frames/s there.
struct ControlState {
  bool allowed = true;
  std::uint32_t rate = 0;
};
[[nodiscard]] ControlState control_at(const Network& network, const Port& port, std::size_t kind);

/// Frames of subscriptions on a CAN network: as the gateway with that port sends them, and the mask
/// by which others' are received. Nothing: the tag of kSubscribeSubject is not known, or the port
/// states no node.
[[nodiscard]] std::optional<FrameIdentity> subscription_frames(const Network& network,
                                                               const Port& port);

/// The rules of all control traffic of one gateway, sorted by entry. A kind that is switched off
/// has rules that refuse. A number that a Binding gives to a channel is that channel's alone. Where
/// the tag of kSubscribeSubject is not known, it has no rules. `asker`: the user who asks for tags
/// as the node of a Port, beside its control_uid.
[[nodiscard]] GateState control_rules(const System& system, std::size_t gateway,
                                      std::optional<std::uint32_t> asker = {});

}  // namespace mlcca::core
