// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/genl.hpp"

#include <linux/genetlink.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>

#include <array>
#include <cstring>

namespace mlcca::net::genl {
namespace {

constexpr std::size_t kAddressOctets = 6;

/// The content after the header; nullopt if the message is shorter than its stated length.
std::optional<Octets> payload_of(Octets octets, nlmsghdr& header) {
  if (octets.size() < sizeof header) return {};
  std::memcpy(&header, octets.data(), sizeof header);
  if (header.nlmsg_len < sizeof header || header.nlmsg_len > octets.size()) return {};
  return octets.first(header.nlmsg_len).subspan(sizeof header);
}

template <class T>
std::optional<T> number(const std::optional<Octets>& content) {
  if (!content || content->size() != sizeof(T)) return {};
  T value{};
  std::memcpy(&value, content->data(), sizeof value);
  return value;
}

}  // namespace

std::optional<Octets> Attributes::find(std::uint16_t type) const {
  for (Octets rest = octets_; rest.size() >= sizeof(nlattr);) {
    nlattr head{};
    std::memcpy(&head, rest.data(), sizeof head);
    if (head.nla_len < sizeof head || head.nla_len > rest.size()) return {};
    if ((head.nla_type & NLA_TYPE_MASK) == type)
      return rest.first(head.nla_len).subspan(sizeof head);
    const std::size_t step = NLA_ALIGN(std::size_t{head.nla_len});
    if (step >= rest.size()) return {};
    rest = rest.subspan(step);
  }
  return {};
}

std::optional<std::uint8_t> Attributes::u8(std::uint16_t type) const {
  return number<std::uint8_t>(find(type));
}
std::optional<std::uint16_t> Attributes::u16(std::uint16_t type) const {
  return number<std::uint16_t>(find(type));
}
std::optional<std::uint32_t> Attributes::u32(std::uint16_t type) const {
  return number<std::uint32_t>(find(type));
}
std::optional<std::uint64_t> Attributes::u64(std::uint16_t type) const {
  return number<std::uint64_t>(find(type));
}

std::optional<std::string> Attributes::mac(std::uint16_t type) const {
  static constexpr std::string_view digits = "0123456789abcdef";
  const auto content = find(type);
  if (!content || content->size() != kAddressOctets) return {};
  std::string text;
  for (const std::byte octet : *content) {
    if (!text.empty()) text += ':';
    text += digits[std::to_integer<std::size_t>(octet >> 4)];
    text += digits[std::to_integer<std::size_t>(octet & std::byte{0xf})];
  }
  return text;
}

Attributes Attributes::nested(std::uint16_t type) const {
  return Attributes(find(type).value_or(Octets{}));
}

std::optional<Message> read_message(Octets octets) {
  nlmsghdr header{};
  const auto payload = payload_of(octets, header);
  genlmsghdr generic{};
  if (!payload || payload->size() < sizeof generic) return {};
  std::memcpy(&generic, payload->data(), sizeof generic);
  return Message{.family = header.nlmsg_type,
                 .command = generic.cmd,
                 .attributes = Attributes(payload->subspan(sizeof generic))};
}

std::optional<Attributes> read_route_message(Octets octets, std::uint16_t type, std::size_t fixed) {
  nlmsghdr header{};
  const auto payload = payload_of(octets, header);
  const std::size_t skipped = NLMSG_ALIGN(fixed);
  if (!payload || header.nlmsg_type != type || payload->size() < skipped) return {};
  return Attributes(payload->subspan(skipped));
}

std::optional<std::uint32_t> index_of_link(Octets octets) {
  ifinfomsg fixed{};
  if (!read_route_message(octets, RTM_NEWLINK, sizeof fixed)) return {};
  std::memcpy(&fixed, octets.data() + NLMSG_HDRLEN, sizeof fixed);
  return static_cast<std::uint32_t>(fixed.ifi_index);
}

}  // namespace mlcca::net::genl
