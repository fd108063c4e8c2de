// SPDX-License-Identifier: BSD-2-Clause
#include "tools/elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/ascii.hpp"
#include "base/big_endian.hpp"
#include "base/hash.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::tools {

using core::kExtendedBits;
using core::kExtendedFlag;
using core::Profile;

std::string name_like(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 40)) out += is_of_name(c) ? c : '_';
  return !out.empty() && is_letter(out.front()) ? out : "if" + out;
}

std::string free_name(std::set<std::string>& taken, std::string_view stem, std::string_view end) {
  for (unsigned n = 1;; ++n) {
    const std::string behind = n == 1 ? std::string(end) : fmt::format("{}-{}", end, n);
    std::string out(stem.substr(0, kLongestName - std::min(kLongestName, behind.size())));
    out += behind;
    if (taken.insert(out).second) return out;
  }
}

std::string interface_like(std::string_view text) {
  std::string like = name_like(text).substr(0, kLongestInterface);
  if (text.empty() || text.size() > kLongestInterface ||
      std::string_view(".@+-").contains(text.front()))
    return like;
  return std::ranges::all_of(text, is_of_interface_name) ? std::string(text) : like;
}

std::uint64_t subject_of(std::string_view name) {
  const std::uint64_t hash = hash_of(name);
  return hash == 0 ? 1 : hash;
}

std::optional<IdentifierParts> parts_of(Profile profile, std::uint32_t id) {
  const core::ProfileTraits& traits = core::traits_of(profile);
  const bool is_extended = (id & kExtendedFlag) != 0;
  if (traits.form != core::IdentifierForm::stated &&
      is_extended != (traits.form == core::IdentifierForm::extended))
    return std::nullopt;
  if (traits.parts == nullptr)
    return IdentifierParts{.number = id & (kExtendedFlag | kExtendedBits)};
  return traits.parts(id & kExtendedBits);
}

bool is_control(Profile profile, std::uint32_t id) {
  return std::ranges::any_of(core::traits_of(profile).control, [id](const auto& kind) {
    return !kind.is_tagged &&
           std::ranges::any_of(kind.frames, [id](const core::ControlFrames& frames) {
             return (id & frames.identity.mask) == frames.identity.id;
           });
  });
}

namespace {

/// The digits of a number with the flag of an extended identifier.
constexpr unsigned kExtendedDigits = 8;

unsigned digits_of(std::uint32_t number, unsigned digits) {
  return (number & kExtendedFlag) != 0 ? kExtendedDigits : digits;
}

}  // namespace

std::string number_text(Profile profile, std::uint32_t number) {
  const core::NumberText& text = core::traits_of(profile).number_text;
  const std::uint32_t bits = number & kExtendedBits;
  return text.decimal ? fmt::format("{}", bits)
                      : fmt::format("0x{:0{}x}", bits, digits_of(number, text.digits));
}

std::string channel_name(Profile profile, std::string_view network, std::uint32_t number) {
  const core::NumberText& text = core::traits_of(profile).number_text;
  const std::uint32_t bits = number & kExtendedBits;
  return fmt::format("{}-{}", network, text.stem) +
         (text.decimal ? fmt::format("{}", bits)
                       : fmt::format("{:0{}X}", bits, digits_of(number, text.name_digits)));
}

std::string channel_name(std::string_view network, core::Subject subject) {
  const std::string text = spelled(subject);
  if (text.empty()) return fmt::format("{}-{:016x}", network, subject);
  std::string out = fmt::format("{}-", network);
  for (const char c : text) out += is_of_name(c) ? c : '_';
  return out;
}

std::string spelled(core::Subject subject) {
  std::string out;
  for (const std::uint8_t octet : big_endian(subject)) out += static_cast<char>(octet);
  out.erase(out.find_last_not_of('\0') + 1);  // short names are padded with null characters
  const bool is_written = std::ranges::all_of(
      out, [](char c) { return is_alphanumeric(c) || std::string_view("_.!/: ").contains(c); });
  return is_written ? out : std::string();
}

std::string binding_element(Profile profile, std::uint32_t number,
                            std::optional<std::uint32_t> priority,
                            std::optional<std::uint32_t> destination) {
  const core::ProfileTraits& traits = core::traits_of(profile);
  const std::string_view element = traits.element.substr(traits.element.find(' ') + 1);
  std::string stated;
  if (traits.form == core::IdentifierForm::stated)
    stated = (number & kExtendedFlag) != 0 ? " form=\"extended\"" : " form=\"standard\"";
  if (priority && traits.has_number_priority) stated += fmt::format(" priority=\"{}\"", *priority);
  if (destination && traits.destination_bits != 0)
    stated += fmt::format(" destination=\"0x{:02x}\"", *destination);
  return fmt::format("<{0}{1}>{2}</{0}>", element, stated, number_text(profile, number));
}

std::string profile_word(Profile profile) {
  return std::string(core::words::kProfiles.of(profile));
}

std::string time_words(std::uint64_t ns) {
  constexpr std::array<std::pair<std::uint64_t, const char*>, 4> units = {
      {{1'000'000'000, "s"}, {1'000'000, "ms"}, {1'000, "us"}, {1, "ns"}}};
  for (const auto& [size, name] : units) {
    if (ns < size) continue;
    std::string out = std::to_string(ns / size);
    if (ns % size != 0) {
      std::string fraction = std::to_string(size + ns % size).substr(1);
      while (fraction.ends_with('0')) fraction.pop_back();
      out += "." + fraction;
    }
    return out + name;
  }
  return "0ns";
}

namespace {

/// Whether `round` is within a part of it of `ns`.
bool is_near(std::uint64_t ns, std::uint64_t round, std::uint64_t part) {
  return round - round / part <= ns && ns <= round + round / part;
}

}  // namespace

std::uint64_t nominal(std::uint64_t ns) {
  constexpr std::array<unsigned, 12> nice = {100, 120, 125, 150, 160, 200,
                                             250, 300, 400, 500, 600, 800};
  std::uint64_t ten = 1;
  while (ten <= ns / 10) ten *= 10;
  if (ten < 100) return ns;
  for (const std::uint64_t scale : {ten, ten * 10})  // 9.9 is near 10
    for (const unsigned n : nice)
      if (const std::uint64_t round = n * (scale / 100); is_near(ns, round, 50)) return round;
  const std::uint64_t two = ten / 10;
  if (const std::uint64_t round = (ns + two / 2) / two * two; is_near(ns, round, 100)) return round;
  return ns / (two / 10) * (two / 10);
}

}  // namespace mlcca::tools
