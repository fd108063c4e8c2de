// SPDX-License-Identifier: BSD-2-Clause
// Octets as text: "00ff" is of two.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "relay/layers/layer.hpp"

namespace mlcca::relay {

inline std::vector<std::uint8_t> bytes(std::string_view hex) {
  std::vector<std::uint8_t> out;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    out.push_back(
        static_cast<std::uint8_t>(std::stoul(std::string(hex.substr(i, 2)), nullptr, 16)));
  return out;
}

inline std::string hex(Octets octets) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  for (const std::uint8_t octet : octets) {
    out += digits[octet >> 4U];
    out += digits[octet & 0xfU];
  }
  return out;
}

}  // namespace mlcca::relay
