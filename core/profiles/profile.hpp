// SPDX-License-Identifier: BSD-2-Clause
// How the frames of a network name their channel and their sender: the one place that knows the
// identifiers of each profile.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Flags of a CAN identifier as the kernel carries them.
inline constexpr std::uint32_t kExtendedFlag = 0x80000000U;
inline constexpr std::uint32_t kRemoteFlag = 0x40000000U;

/// Bits of an identifier without flags.
inline constexpr std::uint32_t kStandardBits = 0x7ff;
inline constexpr std::uint32_t kExtendedBits = 0x1fffffff;

/// What a profile asks of descriptions.
struct ProfileTraits {
  std::string_view element;    ///< of a Binding, with its article: "an ETag"
  std::uint32_t first = 0;     ///< of the numbers that channels may have
  std::uint32_t last = 0;      ///< raw: of extended identifiers
  int last_node = -1;          ///< of senders, -1: they have no numbers of their own
  bool remote_frames = false;  ///< there are some
  bool xl = false;
};
[[nodiscard]] const ProfileTraits& traits_of(Profile profile);

/// Senders have numbers there, and each must state its own.
[[nodiscard]] inline bool has_nodes(Profile profile) { return traits_of(profile).last_node >= 0; }

/// The publisher has what its frames on the network must carry.
[[nodiscard]] bool can_send(const Publisher& publisher, const Network& network);

/// Who a publisher is to those who receive its frames. Two publishers with one sender could not be
/// told apart: what one is granted the other would use.
struct Sender {
  std::size_t channel = 0;
  Place place;
  std::optional<std::uint8_t> node;
  std::optional<std::uint32_t> uid;
  auto operator<=>(const Sender&) const = default;
};
/// Nothing where several may be alike (Ethernet without nodes, networks without a profile), or
/// where what would tell them apart is not stated.
[[nodiscard]] std::optional<Sender> sender_of(const System& system, const Publisher& publisher);
/// What the second publisher with a sender needs to be another one, as a clause.
[[nodiscard]] std::string_view way_to_differ(const Publisher& publisher);

/// A PGN below PDU format 240 (SAE J1939-21: PDU1) is sent to somebody, and its low byte is 0.
[[nodiscard]] constexpr bool has_destination(std::uint32_t pgn) {
  constexpr std::uint32_t pdu2 = 240;
  return (pgn >> 8 & 0xff) < pdu2;
}

/// Frames of which (identifier & mask) == id, with kExtendedFlag in its place. What a description
/// leaves open is not in the mask.
struct FrameIdentity {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  auto operator<=>(const FrameIdentity&) const = default;
};

/// What all frames of a publisher on the network have. Nothing where it lacks a node or has one
/// that the profile does not know, and where the network has no profile. `fragmented`: see
/// core/model/medium.hpp; the frames of an event are marked.
[[nodiscard]] std::optional<FrameIdentity> identity_of(const Publisher& publisher,
                                                       const Network& network,
                                                       const Binding& binding, bool fragmented);

/// Whether a frame can belong to both bindings of a network of that profile.
[[nodiscard]] bool clash(Profile profile, const Binding& a, const Binding& b);

}  // namespace mlcca::core
