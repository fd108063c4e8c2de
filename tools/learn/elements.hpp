// SPDX-License-Identifier: BSD-2-Clause
// What elements of a drafted description have: names, numbers, subjects.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/model/system.hpp"

namespace mlcca::learn {

/// A name that a description may have, like `text`: a letter, then letters, digits, dots,
/// underscores, hyphens.
[[nodiscard]] std::string name_like(std::string_view text);
/// A name that an interface may have: that of a recording can be longer, or have other characters.
[[nodiscard]] std::string interface_like(std::string_view text);
/// The same subject whenever a channel of that name is drafted.
[[nodiscard]] std::uint64_t subject_of(std::string_view name);
/// A number of a channel (see Event) as descriptions have it: "0x123".
[[nodiscard]] std::string number_text(core::Profile profile, std::uint32_t number);
/// "can0-123", "can0-pgn-F004".
[[nodiscard]] std::string channel_name(core::Profile profile, std::string_view network,
                                       std::uint32_t number);
/// What a Binding contains. `priority`: of profiles whose bindings have one; nothing: any.
[[nodiscard]] std::string binding_element(core::Profile profile, std::uint32_t number,
                                          std::optional<std::uint32_t> priority);
[[nodiscard]] std::string profile_word(core::Profile profile);

}  // namespace mlcca::learn
