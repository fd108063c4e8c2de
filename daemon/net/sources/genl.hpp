// SPDX-License-Identifier: BSD-2-Clause
// Reads netlink messages. Attributes are read from octets that need not be well-formed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace mlcca::net::genl {

/// The octets of one netlink message with its header, or of the content of an attribute.
using Octets = std::span<const std::byte>;

/// The attributes of one level of a message, as references to its octets. An attribute that does
/// not fit into the octets ends the list. Of several with the same number the first counts.
class Attributes {
 public:
  Attributes() = default;
  explicit Attributes(Octets octets) : octets_(octets) {}

  [[nodiscard]] bool has(std::uint16_t type) const { return find(type).has_value(); }
  /// Numbers in the byte order of this machine. nullopt if absent or of another size.
  [[nodiscard]] std::optional<std::uint8_t> u8(std::uint16_t type) const;
  [[nodiscard]] std::optional<std::uint16_t> u16(std::uint16_t type) const;
  [[nodiscard]] std::optional<std::uint32_t> u32(std::uint16_t type) const;
  [[nodiscard]] std::optional<std::uint64_t> u64(std::uint16_t type) const;
  /// An Ethernet address in the form "02:00:00:00:0a:01". nullopt if absent or not of 6 octets.
  [[nodiscard]] std::optional<std::string> mac(std::uint16_t type) const;
  /// The attributes inside an attribute; empty if it is absent.
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
/// nullopt if the message is shorter than its headers, or than its stated length.
[[nodiscard]] std::optional<Message> read_message(Octets octets);

/// The attributes of an rtnetlink message of `type`, after `fixed` octets (the struct with which
/// this type begins). nullopt if it has another type or is too short.
[[nodiscard]] std::optional<Attributes> read_route_message(Octets octets, std::uint16_t type,
                                                           std::size_t fixed);
/// The index of the interface of an RTM_NEWLINK message; nullopt if it is not such a message.
[[nodiscard]] std::optional<std::uint32_t> index_of_link(Octets octets);

}  // namespace mlcca::net::genl
