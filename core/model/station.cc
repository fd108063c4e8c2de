// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/station.hpp"

#include "base/number.hpp"

namespace mlcca::core {
namespace {

constexpr std::uint64_t kMac = std::uint64_t{1} << 48;
constexpr unsigned kOctet = 8;

/// `octets` numbers of that base, each followed by the separator but the last, and nothing else.
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

}  // namespace

std::optional<Station> station_of(std::string_view text) {
  if (const auto ip = read(text, 4, '.', 10, 3)) {
    constexpr unsigned first_group = 224;  // from there on multicast, reserved, broadcast
    constexpr unsigned loopback = 127;     // never the source of what comes over a link
    const unsigned first = octet(*ip, 3);
    if (first == 0 || first == loopback || first >= first_group) return std::nullopt;
    return Station{*ip};
  }
  const auto mac = read(text, 6, ':', 16, 2);
  if (!mac || *mac == 0 || (octet(*mac, 5) & 1) != 0) return std::nullopt;
  return Station{kMac | *mac};
}

std::string to_text(Station station) {
  std::string text;
  if (station.is_wildcard()) return text;
  const bool mac = (station.bits & kMac) != 0;
  for (unsigned n = mac ? 6 : 4; n-- > 0;) {
    constexpr std::string_view digits = "0123456789abcdef";
    const unsigned number = octet(station.bits, n);
    if (!text.empty()) text += mac ? ':' : '.';
    if (mac)
      (text += digits[number / 16]) += digits[number % 16];
    else
      text += std::to_string(number);
  }
  return text;
}

}  // namespace mlcca::core
