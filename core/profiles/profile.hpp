// SPDX-License-Identifier: BSD-2-Clause
// What is asked of a profile: how the frames of a network name their channel and their sender, how
// long they are, what passes beside channels, and what descriptions say of it. Each profile answers
// in the file of its name; list.inc has them all.
#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Flags of a CAN identifier as the kernel carries them.
inline constexpr std::uint32_t kExtendedFlag = 0x80000000U;
inline constexpr std::uint32_t kRemoteFlag = 0x40000000U;

/// Bits of an identifier without flags.
inline constexpr std::uint32_t kStandardBits = 0x7ff;
inline constexpr std::uint32_t kExtendedBits = 0x1fffffff;

/// Frames of which (identifier & mask) == id, with kExtendedFlag in its place. What a description
/// leaves open is not in the mask.
struct FrameIdentity {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  auto operator<=>(const FrameIdentity&) const = default;
};

/// Of a message about a subscription, at most: what it requires, or why it is refused.
inline constexpr std::uint16_t kSubscriptionBytes = 256;

/// As FAMOUSO's nodes have it in such messages.
inline constexpr std::uint8_t kSubscriptionPriority = 0x7d;

/// Frames of a kind of control traffic, as identifier and mask with kExtendedFlag in both.
struct ControlFrames {
  FrameIdentity identity;
  std::uint16_t max_length = 8;
  bool asks_for_tag = false;  ///< of the broker
  /// Of messages that only a network with a SubscriptionPolicy has.
  bool of_subscriptions = false;
};

/// What a profile needs beside its channels.
struct ControlKind {
  std::string_view name;  ///< "address-claim"
  std::span<const ControlFrames> frames;
  std::uint32_t rate = 0;   ///< frames/s in each direction, unless a description says another
  std::uint32_t burst = 0;  ///< frames that may come at once, beyond one
  /// can-j1939 sends them itself, whoever gave it the data. Such frames carry what no gate can look
  /// into, so that they pass only where a description names them.
  bool is_carrier = false;
  /// Its frames have the etag of kSubscribeSubject, which is dealt at run time: here it is open.
  bool is_tagged = false;
};

/// How events are carried that are longer than a frame.
struct Fragmentation {
  unsigned tail = 0;  ///< payload bytes of an unfragmented frame that are not the event's
  /// At most: of an event that is too long, those of the longest one or more.
  unsigned (*frames)(Value bytes, unsigned frame_bytes) = nullptr;
  Value (*largest)(unsigned frame_bytes) = nullptr;  ///< event
  /// Payload bytes of the last frame; 0: all but one frame are full, and it is not said which.
  unsigned (*last_frame)(Value bytes, unsigned frames, unsigned frame_bytes) = nullptr;
  std::string_view room;  ///< in which the largest event is carried: "in 4096 frames"
  /// What keeps events of this binding in one frame, as a clause; empty: nothing. nullptr: nothing.
  std::string_view (*obstacle)(const Binding& binding) = nullptr;
  /// Identities of the frames that carry an event in several frames, where these are not its own,
  /// from its own identity: the first frame, and the others.
  std::array<FrameIdentity, 2> (*carriers)(const FrameIdentity& event) = nullptr;
  /// Between two frames of an event, as the sender takes it, at least and at most; 0: nothing.
  Value least_pause = 0;    ///< ns
  Value longest_pause = 0;  ///< ns
};

enum class IdentifierForm : std::uint8_t { extended, standard, stated };

/// A profile. What it does not have is left out; what has no default here each must have.
struct ProfileTraits {
  std::string_view element;  ///< of a Binding, with its article: "an ETag"
  IdentifierForm form = IdentifierForm::extended;
  std::uint32_t first = 0;      ///< of the numbers that channels may have
  std::uint32_t last = 0;       ///< where the form is stated: of extended identifiers
  int last_node = -1;           ///< of senders, -1: they have no numbers of their own
  std::string_view nodes = {};  ///< these numbers in words: "0 to 127"
  /// Bits of an identifier that are the number. What a binding leaves open may be others.
  std::uint32_t number_bits = kExtendedFlag | kExtendedBits;
  bool deals_tags = false;           ///< a broker deals the numbers, in the low bits, up to `last`
  bool has_sender_priority = false;  ///< a publisher states it
  bool has_number_priority = false;  ///< a binding states it with the number

  /// What is wrong with the number of a described binding, a clause each.
  std::vector<std::string> (*problems)(const Binding& binding);
  /// The same of a channel that is not described, of a number from `first` to `last`; or nullptr.
  std::string (*unlisted_problem)(const Binding& binding) = nullptr;
  /// kExtendedFlag is not in it. The publisher has a node where there are any.
  FrameIdentity (*identity)(const Publisher& publisher, const Binding& binding, bool fragmented);
  /// A frame can belong to both bindings, which have identifiers of one form.
  bool (*overlap)(const Binding& a, const Binding& b);

  bool remote_frames = false;  ///< there are some
  bool xl = false;
  const Fragmentation* fragmentation = nullptr;  ///< of CAN frames; nullptr: there is none
  std::span<const ControlKind> control = {};     ///< in the order of ControlPolicy::kinds

  /// Datagrams of an event that is longer than one, on networks other than CAN, where they carry
  /// the 64-bit subject itself; nullptr: the profile is for CAN alone.
  unsigned (*datagrams)(Value bytes) = nullptr;
  std::span<const ControlKind> datagram_control = {};
};
[[nodiscard]] const ProfileTraits& traits_of(Profile profile);

/// The profile whose bindings have the element.
[[nodiscard]] const ProfileTraits* profile_with_element(std::string_view element);

/// "raw and canopen": those that have what is asked for, in their order. `last`: between the last
/// two.
[[nodiscard]] std::string profiles_with(bool (*has)(const ProfileTraits&),
                                        std::string_view last = " and ");
/// The same behind "profile " or "profiles ".
[[nodiscard]] std::string for_profiles_with(bool (*has)(const ProfileTraits&));
/// "a PGN and a SubjectID".
[[nodiscard]] std::string elements_with(bool (*has)(const ProfileTraits&));

/// A broker deals the numbers of this bus.
[[nodiscard]] inline bool has_broker(const Network& network) {
  return network.kind == NetworkKind::can && traits_of(network.profile).deals_tags;
}

/// Its nodes subscribe by the subject SUBSCRIB.
[[nodiscard]] bool has_subscriptions(const Network& network);

/// Senders have numbers there, and each must state its own.
[[nodiscard]] inline bool has_nodes(Profile profile) { return traits_of(profile).last_node >= 0; }

/// The publisher has what its frames on the network must carry.
[[nodiscard]] bool can_send(const Publisher& publisher, const Network& network);

/// Who a publisher is to those who receive its frames. Two publishers with one sender could not be
/// distinguished: what one is granted the other would use.
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

/// What all frames of a publisher on the network have. Nothing where it lacks a node or has one
/// that the profile does not know, and where the network has no profile. `fragmented`: see
/// core/model/medium.hpp; the frames of an event are marked.
[[nodiscard]] std::optional<FrameIdentity> identity_of(const Publisher& publisher,
                                                       const Network& network,
                                                       const Binding& binding, bool fragmented);

/// Whether a frame can belong to both bindings of a network of that profile.
[[nodiscard]] bool clash(Profile profile, const Binding& a, const Binding& b);

}  // namespace mlcca::core
