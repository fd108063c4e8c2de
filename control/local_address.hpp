// SPDX-License-Identifier: BSD-2-Clause
// Where a program on the gateway receives what others there publish: AnnounceRequest.local and
// Endpoint.local.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::control {

struct LocalAddress {
  static constexpr std::size_t kNameDigits = 5;
  static constexpr std::size_t kKeyDigits = 16;

  /// That the kernel gave to a socket which was bound without one; see unix(7), autobind.
  std::string name;
  /// That datagrams begin with. The receiver's filter drops others before they are queued.
  std::uint64_t key = 0;
};

/// Of hexadecimal digits in lower case: 5 of the name, then 16 of the key. Other names may be those
/// of somebody's service.
[[nodiscard]] std::optional<LocalAddress> local_address_in(std::string_view text);
[[nodiscard]] std::string to_text(const LocalAddress& address);

}  // namespace mlcca::control
