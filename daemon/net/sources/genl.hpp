// SPDX-License-Identifier: BSD-2-Clause
// Reading netlink messages: attributes are taken out of octets that need not be well formed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace mlcca::net::genl {

/// Octets of one netlink message with its header, or of an attribute's content.
using Octets = std::span<const std::byte>;

/// The attributes of one level of a message; they refer to its octets. An attribute that does not
/// fit the octets around it ends the list. Of several with one number the first counts.
class Attributes {
 public:
  Attributes() = default;
  explicit Attributes(Octets octets) : octets_(octets) {}

  [[nodiscard]] bool has(std::uint16_t type) const { return find(type).has_value(); }
  /// Numbers in the order of this machine. Nothing if absent or of another size.
  [[nodiscard]] std::optional<std::uint8_t> u8(std::uint16_t type) const;
  [[nodiscard]] std::optional<std::uint16_t> u16(std::uint16_t type) const;
  [[nodiscard]] std::optional<std::uint32_t> u32(std::uint16_t type) const;
  [[nodiscard]] std::optional<std::uint64_t> u64(std::uint16_t type) const;
  /// An Ethernet address in the form "02:00:00:00:0a:01". Nothing if absent or not of 6 octets.
  [[nodiscard]] std::optional<std::string> mac(std::uint16_t type) const;
  /// What is inside the attribute; no attributes if it is absent.
  [[nodiscard]] Attributes nested(std::uint16_t type) const;

 private:
  [[nodiscard]] std::optional<Octets> find(std::uint16_t type) const;

  Octets octets_;
};

/// A generic netlink message.
struct Message {
  std::uint16_t family = 0;
  std::uint8_t command = 0;
  Attributes attributes;
};
/// Nothing if it is shorter than its headers, or than it says itself.
[[nodiscard]] std::optional<Message> read_message(Octets octets);

/// The attributes of an rtnetlink message of the type `type`, behind `fixed` octets (the struct
/// that this type begins with). Nothing if it is of another type or too short.
[[nodiscard]] std::optional<Attributes> read_route_message(Octets octets, std::uint16_t type,
                                                           std::size_t fixed);
/// The index of the interface that an RTM_NEWLINK message is about. Nothing if it is none.
[[nodiscard]] std::optional<std::uint32_t> index_of_link(Octets octets);

}  // namespace mlcca::net::genl
