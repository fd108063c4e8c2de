// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/elements.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/hash.hpp"
#include "core/model/words.hpp"
#include "tools/learn/frame.hpp"

namespace mlcca::learn {

using core::Profile;

std::string name_like(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 40)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '_' || c == '-';
    out += plain ? c : '_';
  }
  const bool begins_well =
      !out.empty() && ((out[0] >= 'a' && out[0] <= 'z') || (out[0] >= 'A' && out[0] <= 'Z'));
  return begins_well ? out : "if" + out;
}

std::string interface_like(std::string_view text) {
  constexpr std::size_t longest = 15;  // IFNAMSIZ; characters as the schema has them
  std::string like = name_like(text).substr(0, longest);
  if (text.empty() || text.size() > longest || std::string_view(".@+-").contains(text.front()))
    return like;
  const bool plain = std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_.@+-").contains(c);
  });
  return plain ? std::string(text) : like;
}

std::uint64_t subject_of(std::string_view name) {
  const std::uint64_t hash = hash_of(name);
  return hash == 0 ? 1 : hash;
}

std::string number_text(Profile profile, std::uint32_t number) {
  const std::uint32_t bits = number & kIdentifierBits;
  switch (profile) {
    case Profile::cyphal:
      return fmt::format("{}", bits);
    case Profile::j1939:
      return fmt::format("0x{:x}", bits);
    default:
      return (number & kExtended) != 0 ? fmt::format("0x{:08x}", bits)
                                       : fmt::format("0x{:03x}", bits);
  }
}

std::string channel_name(Profile profile, std::string_view network, std::uint32_t number) {
  const auto bits = number & kIdentifierBits;
  switch (profile) {
    case Profile::cyphal:
      return fmt::format("{}-subject-{}", network, bits);
    case Profile::j1939:
      return fmt::format("{}-pgn-{:X}", network, bits);
    case Profile::famouso:
      return fmt::format("{}-etag-{:X}", network, bits);
    case Profile::canopen:
      return fmt::format("{}-cob-{:03X}", network, bits);
    default:
      return (number & kExtended) != 0 ? fmt::format("{}-{:08X}", network, bits)
                                       : fmt::format("{}-{:03X}", network, bits);
  }
}

std::string binding_element(Profile profile, std::uint32_t number,
                            std::optional<std::uint32_t> priority) {
  const std::string text = number_text(profile, number);
  const std::string stated = priority ? fmt::format(" priority=\"{}\"", *priority) : "";
  switch (profile) {
    case Profile::cyphal:
      return fmt::format("<SubjectID{}>{}</SubjectID>", stated, text);
    case Profile::j1939:
      return fmt::format("<PGN{}>{}</PGN>", stated, text);
    case Profile::famouso:
      return fmt::format("<ETag>{}</ETag>", text);
    case Profile::canopen:
      return fmt::format("<COBID>{}</COBID>", text);
    default:
      return fmt::format("<Identifier form=\"{}\">{}</Identifier>",
                         (number & kExtended) != 0 ? "extended" : "standard", text);
  }
}

std::string profile_word(Profile profile) {
  return std::string(core::words::kProfiles.of(profile));
}

}  // namespace mlcca::learn
