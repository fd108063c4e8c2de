// SPDX-License-Identifier: BSD-2-Clause
#include "control/local_address.hpp"

#include "base/number.hpp"

namespace mlcca::control {

std::optional<LocalAddress> local_address_in(std::string_view text) {
  constexpr std::size_t digits = LocalAddress::kNameDigits + LocalAddress::kKeyDigits;
  if (text.size() != digits || text.find_first_not_of("0123456789abcdef") != std::string_view::npos)
    return std::nullopt;
  const auto key =
      number_in<std::uint64_t>(text.substr(LocalAddress::kNameDigits), kHexadecimalBase);
  if (!key) return std::nullopt;
  return LocalAddress{.name = std::string(text.substr(0, LocalAddress::kNameDigits)), .key = *key};
}

std::string to_text(const LocalAddress& address) {
  const std::string digits = hexadecimal(address.key).substr(2);
  return address.name + std::string(LocalAddress::kKeyDigits - digits.size(), '0') + digits;
}

}  // namespace mlcca::control
