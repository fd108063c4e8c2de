// SPDX-License-Identifier: BSD-2-Clause
// The address at which a program on the gateway receives events of publishers on the same gateway
// (AnnounceRequest.local, Endpoint.local).
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::control {

/// A datagram socket in the abstract namespace, and a secret that its datagrams begin with.
struct LocalAddress {
  static constexpr std::size_t kNameDigits = 5;
  static constexpr std::size_t kKeyDigits = 16;

  /// The name that the kernel gave to a socket that was bound without one (autobind, unix(7)).
  std::string name;
  /// The key that datagrams begin with. The receiver's socket filter drops others before they are
  /// queued.
  std::uint64_t key = 0;
};

/// Parses lower-case hexadecimal digits: 5 of the name, then 16 of the key. Nullopt for all else:
/// another form of name could be that of a service.
[[nodiscard]] std::optional<LocalAddress> local_address_in(std::string_view text);
[[nodiscard]] std::string to_text(const LocalAddress& address);

}  // namespace mlcca::control
