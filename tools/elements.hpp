// SPDX-License-Identifier: BSD-2-Clause
// What elements of a drafted description have: names, numbers, subjects, times; and what the
// identifier of a frame says of its channel.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/model/system.hpp"

namespace mlcca::tools {

/// A name that a description may have, like `text`: a letter, then letters, digits, dots,
/// underscores, hyphens.
[[nodiscard]] std::string name_like(std::string_view text);
/// A name that an interface may have: that of a recording can be longer, or have other characters.
[[nodiscard]] std::string interface_like(std::string_view text);
/// The same subject whenever a channel of that name is drafted.
[[nodiscard]] std::uint64_t subject_of(std::string_view name);
/// What an identifier says in a profile.
struct IdentifierParts {
  /// Of the channel: an identifier (raw) with core::kExtendedFlag where it has 29 bits, a COB-ID,
  /// PGN, subject-id or etag.
  std::uint32_t number = 0;
  std::uint32_t node = 0;      ///< of the sender, where the profile has nodes
  std::uint32_t priority = 0;  ///< where the profile has priorities, as it has them
  bool is_fragment = false;    ///< FAMOUSO: one frame of several
};
/// Of an identifier with its flags. Nothing where no channel of the profile can have it: it has the
/// other form, or is of a service or a management tag.
[[nodiscard]] std::optional<IdentifierParts> parts_of(core::Profile profile, std::uint32_t id);

/// The profile's own control traffic, which needs no channel. Not what has a tag that a broker
/// deals: any channel may have that identifier.
[[nodiscard]] bool is_control(core::Profile profile, std::uint32_t id);

/// A number of a channel as descriptions have it: "0x123".
[[nodiscard]] std::string number_text(core::Profile profile, std::uint32_t number);
/// "can0-123", "can0-pgn-F004".
[[nodiscard]] std::string channel_name(core::Profile profile, std::string_view network,
                                       std::uint32_t number);
/// "eth0-44697374616e6365", of a subject as frames of Ethernet carry it.
[[nodiscard]] std::string channel_name(std::string_view network, core::Subject subject);
/// "Distance": what a subject of FAMOUSO spells; empty: it spells nothing that people write.
[[nodiscard]] std::string spelled(core::Subject subject);
/// What a Binding contains. `priority`: of profiles whose bindings have one; nothing: any.
[[nodiscard]] std::string binding_element(core::Profile profile, std::uint32_t number,
                                          std::optional<std::uint32_t> priority);
[[nodiscard]] std::string profile_word(core::Profile profile);

/// "50ms", "1.25ms", "320us": exact.
[[nodiscard]] std::string time_words(std::uint64_t ns);
/// The largest of the numbers 1, 1.2, 1.25, 1.5, 1.6, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten
/// that is within 2 % of `ns`; `ns` itself to two digits, rounded down, where there is none.
[[nodiscard]] std::uint64_t nominal(std::uint64_t ns);
/// Period of what was seen once, ns: it is assumed.
inline constexpr std::uint64_t kPeriodOfOne = 100'000'000;

}  // namespace mlcca::tools
