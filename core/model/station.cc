// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/station.hpp"

#include "base/number.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {
namespace {

constexpr std::uint64_t kMac = std::uint64_t{1} << 48;
constexpr std::uint64_t kShort = std::uint64_t{1} << 49;
constexpr std::uint64_t kExtended = std::uint64_t{1} << 56;
constexpr std::uint16_t kFirstGroup = 0xfffe;  // of short addresses
constexpr unsigned kOctet = 8;
constexpr unsigned kWord = 16;
constexpr std::string_view kDigits = "0123456789abcdef";

/// Reads exactly `octets` numbers of base `base` with separators between them, and nothing behind.
std::optional<std::uint64_t> read(std::string_view text, unsigned octets, char separator, int base,
                                  std::size_t most_digits) {
  std::uint64_t out = 0;
  for (unsigned i = 0; i < octets; ++i) {
    if (i > 0) {
      if (!text.starts_with(separator)) return std::nullopt;
      text.remove_prefix(1);
    }
    const std::string_view before = text;
    const auto octet = take_number<std::uint8_t>(text, base);
    const std::size_t digits = before.size() - text.size();
    const bool padded = base == kHexadecimalBase ? digits != 2 : digits > 1 && before[0] == '0';
    if (!octet || digits > most_digits || padded) return std::nullopt;
    out = out << kOctet | *octet;
  }
  if (!text.empty()) return std::nullopt;
  return out;
}

std::uint8_t octet(std::uint64_t bits, unsigned from_last) {
  return static_cast<std::uint8_t>(bits >> (kOctet * from_last));
}

/// Takes four hexadecimal digits after "0x" off the text, such as "0xbeef".
std::optional<std::uint16_t> take_word(std::string_view& text) {
  constexpr std::size_t digits = 4;
  if (!text.starts_with("0x") && !text.starts_with("0X")) return std::nullopt;
  text.remove_prefix(2);
  const std::size_t before = text.size();
  const auto word = take_number<std::uint16_t>(text, kHexadecimalBase);
  return before - text.size() == digits ? word : std::nullopt;
}

/// Reads a PAN and a short address, such as "0xbeef:0x0001".
std::optional<Station> short_address(std::string_view text) {
  const auto pan = take_word(text);
  if (!pan || !text.starts_with(':')) return std::nullopt;
  text.remove_prefix(1);
  const auto address = take_word(text);
  if (!address || !text.empty() || *address >= kFirstGroup) return std::nullopt;
  return Station{kShort | std::uint64_t{*pan} << kWord | *address};
}

void add_hexadecimal(std::string& to, std::uint64_t bits, unsigned octets) {
  for (unsigned n = octets; n-- > 0;) {
    const unsigned number = octet(bits, n);
    (to += kDigits[number / 16]) += kDigits[number % 16];
  }
}

/// Formats octets with colons between them.
std::string colons(std::uint64_t bits, unsigned octets) {
  std::string text;
  for (unsigned n = octets; n-- > 0;) {
    if (!text.empty()) text += ':';
    add_hexadecimal(text, octet(bits, n), 1);
  }
  return text;
}

}  // namespace

std::optional<Station> station_of(std::string_view text) {
  if (const auto ip = read(text, 4, '.', 10, 3)) {
    constexpr unsigned first_group = 224;  // from there on multicast, reserved, broadcast
    constexpr unsigned loopback = 127;     // never the source of what comes over a link
    const unsigned first = octet(*ip, 3);
    if (first == 0 || first == loopback || first >= first_group) return std::nullopt;
    return Station{*ip};
  }
  if (const auto mac = read(text, 6, ':', 16, 2)) {
    if (*mac == 0 || (octet(*mac, 5) & 1) != 0) return std::nullopt;
    return Station{kMac | *mac};
  }
  if (const auto extended = read(text, 8, ':', 16, 2)) {
    if (*extended == 0 || (*extended & kExtended) != 0) return std::nullopt;
    return Station{kExtended | *extended};
  }
  return short_address(text);
}

std::optional<Station> station_on(NetworkKind kind, std::string_view text) {
  const auto station = station_of(text);
  const bool wpan = kind == NetworkKind::ieee802154;
  return station && station->is_wpan() == wpan ? station : std::nullopt;
}

std::string_view station_words(NetworkKind kind) {
  if (kind == NetworkKind::ieee802154)
    return "the extended address of one station, such as 02:00:00:00:00:00:00:01, or its PAN and "
           "short address, such as 0xbeef:0x0001";
  return "the IPv4 or MAC address of one station, such as 192.0.2.7";
}

std::string to_text(Station station) {
  const std::uint64_t bits = station.bits;
  std::string text;
  if (station.is_wildcard()) return text;
  if ((bits & kExtended) != 0) return colons(bits & ~kExtended, 8);
  if ((bits & kShort) != 0) {
    add_hexadecimal(text += "0x", bits >> kWord, 2);
    add_hexadecimal(text += ":0x", bits, 2);
    return text;
  }
  if ((bits & kMac) != 0) return colons(bits, 6);
  for (unsigned n = 4; n-- > 0;) {
    if (!text.empty()) text += '.';
    text += std::to_string(octet(bits, n));
  }
  return text;
}

}  // namespace mlcca::core
