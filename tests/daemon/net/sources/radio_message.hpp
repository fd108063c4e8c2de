// SPDX-License-Identifier: BSD-2-Clause
// Netlink messages as the kernel writes them, made by libnl.
#pragma once
#include <linux/netlink.h>
#include <netlink/attr.h>
#include <netlink/genl/genl.h>
#include <netlink/msg.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/handle.hpp"
#include "daemon/net/sources/genl.hpp"

namespace mlcca::test {

using Mac = std::array<std::uint8_t, 6>;

class MessageMaker {
 public:
  static constexpr std::uint16_t kFamily = 0x1c;

  /// A generic netlink message of the family kFamily.
  explicit MessageMaker(std::uint8_t command) : message_(nlmsg_alloc()) {
    genlmsg_put(message_.get(), 0, 0, kFamily, 0, 0, command, 1);
  }
  /// An rtnetlink message that begins with `fixed`.
  template <class T>
  MessageMaker(std::uint16_t type, T fixed) : message_(nlmsg_alloc_simple(type, 0)) {
    nlmsg_append(message_.get(), &fixed, sizeof fixed, NLMSG_ALIGNTO);
  }

  MessageMaker& u8(int type, std::uint8_t v) { return put(type, &v, sizeof v); }
  MessageMaker& u16(int type, std::uint16_t v) { return put(type, &v, sizeof v); }
  MessageMaker& u32(int type, std::uint32_t v) { return put(type, &v, sizeof v); }
  MessageMaker& u64(int type, std::uint64_t v) { return put(type, &v, sizeof v); }
  MessageMaker& mac(int type, const Mac& v) { return put(type, v.data(), v.size()); }
  MessageMaker& flag(int type) { return put(type, nullptr, 0); }
  MessageMaker& put(int type, const void* content, std::size_t size) {
    nla_put(message_.get(), type, static_cast<int>(size), content);
    return *this;
  }
  MessageMaker& begin(int type) {
    nested_.push_back(nla_nest_start(message_.get(), type));
    return *this;
  }
  MessageMaker& end() {
    nla_nest_end(message_.get(), nested_.back());
    nested_.pop_back();
    return *this;
  }

  [[nodiscard]] std::vector<std::byte> octets() const {
    const nlmsghdr* const header = nlmsg_hdr(message_.get());
    const auto* const first = reinterpret_cast<const std::byte*>(header);
    return {first, first + header->nlmsg_len};
  }

 private:
  std::unique_ptr<nl_msg, FreeWith<nlmsg_free>> message_;
  std::vector<nlattr*> nested_;
};

/// Reads the message with every octet cut off its end, and with every octet changed: a reader must
/// come back, whatever it says then.
template <class Read>
void expect_survives_damage(const std::vector<std::byte>& octets, Read read) {
  for (std::size_t size = 0; size <= octets.size(); ++size) {
    // A copy of this size only, so that sanitizers see what is read behind it.
    const std::vector<std::byte> cut(octets.begin(), octets.begin() + static_cast<long>(size));
    read(net::genl::Octets(cut));
  }
  for (std::size_t at = 0; at < octets.size(); ++at) {
    for (const unsigned value : {0x00U, 0x01U, 0x7fU, 0x80U, 0xffU}) {
      std::vector<std::byte> changed = octets;
      changed[at] = static_cast<std::byte>(value);
      read(net::genl::Octets(changed));
    }
  }
}

}  // namespace mlcca::test
