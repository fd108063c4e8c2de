// SPDX-License-Identifier: BSD-2-Clause
// Encodings put together by hand, well-formed or not, without the encoder under test.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace mlcca::testing {

using Octets = std::vector<std::uint8_t>;

inline Octets join(std::initializer_list<Octets> parts) {
  Octets all;
  for (const Octets& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// An element with its length in the shortest form; contents of less than 65536 octets.
inline Octets element(std::uint8_t tag, const Octets& contents) {
  const std::size_t n = contents.size();
  Octets header{tag};
  if (n > 255)
    header.insert(header.end(), {0x82, static_cast<std::uint8_t>(n / 256)});
  else if (n > 127)
    header.push_back(0x81);
  header.push_back(static_cast<std::uint8_t>(n % 256));
  return join({header, contents});
}

inline Octets text(std::string_view characters) { return {characters.begin(), characters.end()}; }

inline Octets head(std::uint8_t version, std::uint8_t role, std::uint8_t subject = 0x17) {
  return {0x02, 1, version, 0x0a, 1, role, 0x04, 8, 0, 0, 0, 0, 0, 0, 0, subject};
}
inline const Octets kSubscriberHead = head(1, 1);
inline const Octets kNetworkHead = head(1, 2, 0);

/// A whole encoding: attributes as they are, and what follows them.
inline Octets encoding(const Octets& head, const Octets& attributes, const Octets& rest = {}) {
  return element(0x30, join({head, element(0x30, attributes), rest}));
}

inline Octets user(std::string_view name, const Octets& value = {0x02, 1, 5},
                   const Octets& rest = {}) {
  return element(0x30, join({element(0x0c, text(name)), value, rest}));
}

}  // namespace mlcca::testing
