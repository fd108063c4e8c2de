// SPDX-License-Identifier: BSD-2-Clause
// The interface of profiles: how frames name their channel and sender, how long they are, what
// control traffic passes, and what descriptions state. Each profile is defined in the file of its
// name; list.inc lists all.
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

/// Flags of a CAN identifier as the kernel has them (linux/can.h).
inline constexpr std::uint32_t kExtendedFlag = 0x80000000U;
inline constexpr std::uint32_t kRemoteFlag = 0x40000000U;

/// The bits of an identifier without flags.
inline constexpr std::uint32_t kStandardBits = 0x7ff;
inline constexpr std::uint32_t kExtendedBits = 0x1fffffff;

/// Matches frames with (identifier & mask) == id, where kExtendedFlag is part of both. Bits that a
/// description leaves open are not in the mask.
struct FrameIdentity {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  auto operator<=>(const FrameIdentity&) const = default;
};

/// The most payload bytes of a message about a subscription: its requirements, or why it is
/// refused.
inline constexpr std::uint16_t kSubscriptionBytes = 256;

/// The priority that FAMOUSO nodes use for such messages.
inline constexpr std::uint8_t kSubscriptionPriority = 0x7d;

/// Frames of one kind of control traffic; identifier and mask contain kExtendedFlag.
struct ControlFrames {
  FrameIdentity identity;
  std::uint16_t max_length = 8;
  bool asks_for_tag = false;  ///< they ask the broker for a tag
  /// They occur only on a network with a SubscriptionPolicy.
  bool of_subscriptions = false;
};

/// A kind of control traffic, which a profile needs beside its channels.
struct ControlKind {
  std::string_view name;  ///< "address-claim"
  std::span<const ControlFrames> frames;
  std::uint32_t rate = 0;   ///< frames/s in each direction, unless the description states another
  std::uint32_t burst = 0;  ///< frames that may arrive at once, beyond one
  /// can-j1939 in the kernel sends these frames itself for whatever program. Gates cannot check
  /// what they carry, so they pass only where a description names them.
  bool is_carrier = false;
  /// Its frames carry the etag of kSubscribeSubject, which is assigned at run time and left open
  /// here.
  bool is_tagged = false;
};

/// What a profile encodes in the identifier of a frame.
struct IdentifierParts {
  /// The number of the channel: an identifier (raw) with kExtendedFlag if it has 29 bits, a COB-ID,
  /// PGN, subject-id or etag.
  std::uint32_t number = 0;
  std::uint32_t node = 0;      ///< of the sender, in profiles that have nodes
  std::uint32_t priority = 0;  ///< in profiles that have priorities, in the profile's own scale
  std::optional<std::uint32_t> destination = std::nullopt;  ///< of a number that has one
  bool is_fragment = false;                                 ///< the frame is a part of an event
};

/// How drafts write the number of a channel.
struct NumberText {
  bool decimal = false;      ///< otherwise hexadecimal
  unsigned digits = 1;       ///< at least, in a hexadecimal number; 8 if it has kExtendedFlag
  std::string_view stem{};   ///< in front of it, in the name of its channel: "pgn-"
  unsigned name_digits = 1;  ///< like `digits`, in this name
};

/// How receivers put an event of several frames together.
enum class Reassembly : std::uint8_t {
  counted,    ///< each begins with the number of frames that follow (FAMOUSO)
  marked,     ///< each ends with a byte that says whether it is the first or the last one (Cyphal)
  announced,  ///< the first frame announces length and number of those that follow (J1939)
};

/// How a profile carries events that are longer than a frame.
struct Fragmentation {
  Reassembly reassembly = Reassembly::counted;
  unsigned tail = 0;  ///< payload bytes of an unfragmented frame that do not belong to the event
  /// The number of frames of an event; for one that is too long, at least that of the longest.
  unsigned (*frames)(Value bytes, unsigned frame_bytes) = nullptr;
  Value (*largest)(unsigned frame_bytes) = nullptr;  ///< payload bytes of the largest event
  /// Payload bytes of the last frame; 0: all frames but one are full, and it is open which one is
  /// not.
  unsigned (*last_frame)(Value bytes, unsigned frames, unsigned frame_bytes) = nullptr;
  std::string_view room;  ///< in what the largest event is carried, as text: "in 4096 frames"
  /// Why events of this binding stay in one frame, as a clause; empty if they need not. Null:
  /// always empty.
  std::string_view (*obstacle)(const Binding& binding) = nullptr;
  /// For transport protocols with identifiers of their own: the identities of the first and of all
  /// other frames, derived from that of the event. Null: they have the event's own identity.
  std::array<FrameIdentity, 2> (*carriers)(const FrameIdentity& event) = nullptr;
  /// The pause of the sender between two frames of an event, at least and at most, in ns; 0: none.
  Value least_pause = 0;    ///< ns
  Value longest_pause = 0;  ///< ns
};

/// The form of identifiers: 29 bits, 11 bits, or as each binding states.
enum class IdentifierForm : std::uint8_t { extended, standard, stated };

/// What defines a profile. Members without a default must be set by every profile.
struct ProfileTraits {
  std::string_view element;    ///< element of a Binding with its article: "an ETag"
  bool names_channels = true;  ///< frames name their channel; false without a profile
  IdentifierForm form = IdentifierForm::extended;
  std::uint32_t first = 0;      ///< smallest number of a channel
  std::uint32_t last = 0;       ///< largest number; for form `stated` that of extended identifiers
  int last_node = -1;           ///< largest node number of a sender; -1: senders have none
  std::string_view nodes = {};  ///< the node numbers as text: "0 to 127"
  /// The bits of an identifier that hold the number. Other bits may be left open by a binding.
  std::uint32_t number_bits = kExtendedFlag | kExtendedBits;
  /// The bits of a destination. Where a number has none, or a binding states it, they are compared
  /// like those of the number.
  std::uint32_t destination_bits = 0;
  bool deals_tags = false;  ///< a broker assigns the numbers, which are in the low bits, up to
                            ///< `last`
  bool has_sender_priority = false;  ///< a publisher states the priority
  bool has_number_priority = false;  ///< a binding states the priority with the number

  /// Returns what is wrong with the number of a described binding, a clause each.
  std::vector<std::string> (*problems)(const Binding& binding);
  /// Returns what is wrong with a number between `first` and `last` for an unlisted channel; empty
  /// if nothing is. Null: nothing ever is.
  std::string (*unlisted_problem)(const Binding& binding) = nullptr;
  /// The identity of frames, without kExtendedFlag. The publisher must have a node if the profile
  /// has nodes.
  FrameIdentity (*identity)(const Publisher& publisher, const Binding& binding, bool fragmented);
  /// Whether a frame can match both bindings, which have identifiers of the same form.
  bool (*overlap)(const Binding& a, const Binding& b);

  /// Decodes the bits of an identifier of the profile's form, without kExtendedFlag. Nullopt if no
  /// channel can have it, because it belongs to a service or to management. Null: the identifier
  /// with its flag is the number.
  std::optional<IdentifierParts> (*parts)(std::uint32_t bits) = nullptr;
  NumberText number_text{};

  bool has_heart_beats = false;  ///< nodes send heart-beats (CiA 301), which others may supervise
  /// Requests that write entries of nodes (SDO of CiA 301) have identifiers like events.
  bool has_services = false;
  /// What ProtocolType of DBC files is for it, whose messages are then its numbers and not frames.
  /// Empty: messages are frames.
  std::string_view dbc_protocol{};

  bool remote_frames = false;  ///< remote frames exist
  bool xl = false;
  const Fragmentation* fragmentation = nullptr;  ///< of CAN frames; null: events are never
                                                 ///< fragmented
  std::span<const ControlKind> control = {};     ///< in the order of ControlPolicy::kinds

  /// On networks other than CAN, where datagrams carry the 64-bit subject: the number of datagrams
  /// of an event that does not fit one. Null: the profile is for CAN only.
  unsigned (*datagrams)(Value bytes) = nullptr;
  std::span<const ControlKind> datagram_control = {};
};
/// The definition of a profile.
[[nodiscard]] const ProfileTraits& traits_of(Profile profile);

/// Whether frames name their channel: whether there is a profile.
[[nodiscard]] inline bool names_channels(Profile profile) {
  return traits_of(profile).names_channels;
}
/// Whether events on networks other than CAN are datagrams that carry their subject.
[[nodiscard]] inline bool has_datagrams(Profile profile) {
  return traits_of(profile).datagrams != nullptr;
}
/// How events of several CAN frames are put together; nullopt if there are none.
[[nodiscard]] inline std::optional<Reassembly> reassembly_of(Profile profile) {
  const Fragmentation* const of = traits_of(profile).fragmentation;
  return of == nullptr ? std::nullopt : std::optional(of->reassembly);
}

/// The transport protocol whose frames have identifiers of their own. One profile has one.
[[nodiscard]] const Fragmentation& transport_protocol();

/// The profile whose bindings have that element; null if there is none.
[[nodiscard]] const ProfileTraits* profile_with_element(std::string_view element);

/// The names of the profiles for which `has` returns true: "raw and canopen". `last` separates the
/// last two.
[[nodiscard]] std::string profiles_with(bool (*has)(const ProfileTraits&),
                                        std::string_view last = " and ");
/// The same after "profile " or "profiles ".
[[nodiscard]] std::string for_profiles_with(bool (*has)(const ProfileTraits&));
/// The elements of such profiles: "a PGN and a SubjectID".
[[nodiscard]] std::string elements_with(bool (*has)(const ProfileTraits&));

/// Whether a broker assigns the numbers of channels on this bus.
[[nodiscard]] inline bool has_broker(const Network& network) {
  return network.kind == NetworkKind::can && traits_of(network.profile).deals_tags;
}

/// Whether its nodes announce their subscriptions under the subject SUBSCRIB.
[[nodiscard]] bool has_subscriptions(const Network& network);

/// Whether senders have node numbers, so that each must state its own.
[[nodiscard]] inline bool has_nodes(Profile profile) { return traits_of(profile).last_node >= 0; }

/// Whether the publisher states the node number that its frames on the network need.
[[nodiscard]] bool can_send(const Publisher& publisher, const Network& network);

/// By what receivers recognise a publisher. Two publishers with the same Sender cannot be
/// distinguished: one would use what the other is granted.
struct Sender {
  std::size_t channel = 0;
  Place place;
  std::optional<std::uint8_t> node;
  std::optional<std::uint32_t> uid;
  auto operator<=>(const Sender&) const = default;
};
/// The sender of a publisher's frames. Nullopt if several may be alike (Ethernet without nodes,
/// networks without a profile), or if what would distinguish them is not stated.
[[nodiscard]] std::optional<Sender> sender_of(const System& system, const Publisher& publisher);
/// What the second publisher with the same sender must change, as a clause.
[[nodiscard]] std::string_view way_to_differ(const Publisher& publisher);

/// What all frames of a publisher on the network have in common. Nullopt if the publisher lacks a
/// valid node number that the profile needs, or the network has no profile. `fragmented`: an event
/// takes several frames (core/model/medium.hpp), which are marked.
[[nodiscard]] std::optional<FrameIdentity> identity_of(const Publisher& publisher,
                                                       const Network& network,
                                                       const Binding& binding, bool fragmented);

/// Whether a frame can match both bindings of a network with that profile.
[[nodiscard]] bool clash(Profile profile, const Binding& a, const Binding& b);

}  // namespace mlcca::core
