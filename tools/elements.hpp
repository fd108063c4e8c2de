// SPDX-License-Identifier: BSD-2-Clause
// The parts of a drafted description (by learn and by audit mode): names, numbers, subjects and
// times; and the channel that the identifier of a CAN frame belongs to.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/model/system.hpp"
#include "core/profiles/profile.hpp"
#include "mlcca/der_format.hpp"

namespace mlcca::tools {

/// A valid name of a description that resembles `text`: a letter, then letters, digits, dots,
/// underscores and hyphens, of bounded length.
[[nodiscard]] std::string name_like(std::string_view text);
/// The most characters of a name of a description.
inline constexpr std::size_t kLongestName = der::kMaxName;
/// A name that is not in `taken`: `stem` and `end`, with a number appended if that is taken. The
/// stem is shortened so far that the name has its length. It is taken then.
[[nodiscard]] std::string free_name(std::set<std::string>& taken, std::string_view stem,
                                    std::string_view end = {});
/// The most characters of an interface name: IFNAMSIZ without its null character.
inline constexpr std::size_t kLongestInterface = 15;
/// A valid interface name that resembles `text`, which comes from a recording and may be longer or
/// have other characters. A valid name is returned as it is.
[[nodiscard]] std::string interface_like(std::string_view text);
/// The subject for a drafted channel of that name: its hash, so that it is the same in every draft;
/// never 0.
[[nodiscard]] std::uint64_t subject_of(std::string_view name);
using core::IdentifierParts;
/// Decodes an identifier with its flags (CAN_EFF_FLAG). Nullopt if no channel of the profile can
/// have it: it has the other length, or it belongs to a service or to management.
[[nodiscard]] std::optional<IdentifierParts> parts_of(core::Profile profile, std::uint32_t id);

/// Whether the identifier is control traffic of the profile, which needs no channel. False for an
/// etag that a broker assigns: any channel may get it.
[[nodiscard]] bool is_control(core::Profile profile, std::uint32_t id);

/// The number of a channel in the form of descriptions: "0x123".
[[nodiscard]] std::string number_text(core::Profile profile, std::uint32_t number);
/// A name for a drafted channel: "can0-123", "can0-pgn-F004".
[[nodiscard]] std::string channel_name(core::Profile profile, std::string_view network,
                                       std::uint32_t number);
/// The same for a subject in Ethernet frames: "eth0-Distance" if it is text,
/// "eth0-4e00000000000001" if not. Two texts may have one name, since names have fewer characters.
[[nodiscard]] std::string channel_name(std::string_view network, core::Subject subject);
/// The text that the octets of a FAMOUSO subject spell ("Distance"); empty if they are not
/// printable text.
[[nodiscard]] std::string spelled(core::Subject subject);
/// The content of a Binding element. `priority` is for profiles whose bindings have one; nullopt
/// admits any. The same for `destination` and J1939.
[[nodiscard]] std::string binding_element(core::Profile profile, std::uint32_t number,
                                          std::optional<std::uint32_t> priority,
                                          std::optional<std::uint32_t> destination = std::nullopt);
/// The profile's word in descriptions.
[[nodiscard]] std::string profile_word(core::Profile profile);

/// The exact time in the largest unit that is not longer than it: "50ms", "1.25ms", "320us".
[[nodiscard]] std::string time_words(std::uint64_t ns);
/// The period that a measured period probably stands for: the largest of 1, 1.2, 1.25, 1.5, 1.6, 2,
/// 2.5, 3, 4, 5, 6, 8 times a power of ten within 2 % of `ns`. If there is none: `ns` rounded down
/// to two digits.
[[nodiscard]] std::uint64_t nominal(std::uint64_t ns);
/// The period, in ns, that is assumed for a channel of which only one event was seen.
inline constexpr std::uint64_t kPeriodOfOne = 100'000'000;

}  // namespace mlcca::tools
