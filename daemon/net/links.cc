// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/links.hpp"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/rtnetlink.h>
#include <net/if_arp.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <netlink/route/link.h>
#include <netlink/route/link/can.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <new>
#include <optional>
#include <utility>

#include "base/handle.hpp"
#include "base/system_error.hpp"

namespace mlcca::net {
namespace {

using LinkObject = std::unique_ptr<rtnl_link, FreeWith<rtnl_link_put>>;

std::string text_or_empty(const char* text) { return text == nullptr ? "" : text; }

std::string can_state_name(std::uint32_t state) {
  static constexpr std::array names{"error-active", "error-warning", "error-passive",
                                    "bus-off",      "stopped",       "sleeping"};
  return state < names.size() ? names[state] : "unknown";
}

Link describe(rtnl_link* link) {
  Link out;
  out.ifindex = rtnl_link_get_ifindex(link);
  out.name = text_or_empty(rtnl_link_get_name(link));
  out.kind = text_or_empty(rtnl_link_get_type(link));
  out.alias = text_or_empty(rtnl_link_get_ifalias(link));
  out.is_can = rtnl_link_get_arptype(link) == ARPHRD_CAN;
  out.is_ethernet = rtnl_link_get_arptype(link) == ARPHRD_ETHER;
  out.is_wpan = rtnl_link_get_arptype(link) == ARPHRD_IEEE802154;
  out.up = (rtnl_link_get_flags(link) & IFF_UP) != 0;
  out.running = (rtnl_link_get_flags(link) & IFF_RUNNING) != 0;
  if (rtnl_link_is_can(link) == 0) return out;
  std::uint32_t value = 0;
  if (rtnl_link_can_state(link, &value) == 0) out.can_state = can_state_name(value);
  if (rtnl_link_can_get_bitrate(link, &value) == 0) out.bitrate = value;
  can_bittiming timing{};
  if (rtnl_link_can_get_data_bittiming(link, &timing) == 0) out.data_bitrate = timing.bitrate;
  return out;
}

}  // namespace

Result<Links> Links::open() {
  Fd notices(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE));
  if (!notices) return system_error("rtnetlink notifications", errno);
  sockaddr_nl own{};
  own.nl_family = AF_NETLINK;
  // NOLINTNEXTLINE(*-reinterpret-cast): as bind() has it
  if (::bind(notices.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) < 0)
    return system_error("rtnetlink notifications", errno);
  for (const int group : {RTNLGRP_LINK, RTNLGRP_TC})
    if (::setsockopt(notices.get(), SOL_NETLINK, NETLINK_ADD_MEMBERSHIP, &group, sizeof group) < 0)
      return system_error("rtnetlink notifications", errno);
  Links links(std::move(notices));
  auto table = links.read();
  if (!table) return std::unexpected(table.error());
  links.table_ = std::move(*table);
  return links;
}

Result<InterfaceTable> Links::read() {
  ifinfomsg head{};
  const Message request = new_message(RTM_GETLINK, 0, &head, sizeof head);
  const auto answers = kernel_.dump(request);
  if (!answers) return answers.error().when("reading the interfaces");
  InterfaceTable table;
  answers->each_object(RTM_NEWLINK, [&table](nl_object* object) {
    Link link = describe(reinterpret_cast<rtnl_link*>(object));  // NOLINT(*-reinterpret-cast)
    table.emplace(link.ifindex, std::move(link));
  });
  return table;
}

Result<bool> Links::refresh() {
  receive();
  auto table = read();
  problem_ = table ? "" : table.error().text;
  if (!table) return std::unexpected(table.error());
  const bool changed = *table != table_ || !gone_.empty();
  table_ = std::move(*table);
  return changed;
}

/// New and changed interfaces are read from the table. Interfaces that have gone are taken only
/// from these notifications, and asked for if any were lost.
void Links::receive() {
  constexpr std::size_t most_of_one = std::size_t{256} << 10;
  constexpr int most_in_a_row = 4096;  // what is left keeps the socket readable
  received_.resize(most_of_one);
  for (int i = 0; i < most_in_a_row; ++i) {
    sockaddr_nl sender{};
    socklen_t length = sizeof sender;
    // NOLINTNEXTLINE(*-reinterpret-cast): as recvfrom() has it
    const ssize_t size = ::recvfrom(fd(), received_.data(), received_.size(), MSG_TRUNC,
                                    reinterpret_cast<sockaddr*>(&sender), &length);
    if (size < 0 && errno == EAGAIN) return;
    if (size < 0 && errno == EINTR) continue;
    if (size >= 0 && sender.nl_pid != 0) continue;  // not the kernel
    if (size < 0 || static_cast<std::size_t>(size) > received_.size()) {
      // An overflow (ENOBUFS) or another loss: the lost notifications may have been about traffic
      // control.
      tc_changed_ = true;
      if (size < 0 && errno != ENOBUFS) return;
      continue;
    }
    take_notices(received_.data(), static_cast<std::size_t>(size));
  }
}

void Links::take_notices(const char* notices, std::size_t size) {
  auto left = static_cast<int>(size);
  // NOLINTBEGIN(*-cstyle-cast,*-reinterpret-cast): macros of the kernel's header
  for (const auto* head = reinterpret_cast<const nlmsghdr*>(notices); NLMSG_OK(head, left);
       head = NLMSG_NEXT(head, left)) {
    const int type = head->nlmsg_type;
    if (type >= RTM_NEWQDISC && type <= RTM_GETTFILTER) tc_changed_ = true;
    if (type != RTM_DELLINK) continue;
    if (head->nlmsg_len < NLMSG_LENGTH(sizeof(ifinfomsg))) continue;
    const auto* info = static_cast<const ifinfomsg*>(NLMSG_DATA(head));
    if (info->ifi_family != AF_UNSPEC) continue;  // it has left a bridge, and still exists
    gone_.insert(info->ifi_index);
    const auto attribute = [head](int type_of_it) {
      return nlmsg_find_attr(const_cast<nlmsghdr*>(head), sizeof(ifinfomsg), type_of_it);
    };
    auto* name = attribute(IFLA_IFNAME);
    // Only the message is used, because the table may have been read after the link had gone.
    if (name != nullptr && attribute(IFLA_NEW_NETNSID) != nullptr)
      moved_.push_back({info->ifi_index, text_in(*name)});
  }
  // NOLINTEND(*-cstyle-cast,*-reinterpret-cast)
}

Presence Links::presence(int ifindex) {
  ifinfomsg head{};
  head.ifi_index = ifindex;
  const auto answer = kernel_.get(new_message(RTM_GETLINK, 0, &head, sizeof head));
  if (answer) return Presence::there;
  return answer.error().said == ENODEV ? Presence::gone : Presence::unknown;
}

Result<Traffic> Links::traffic(int ifindex) {
  ifinfomsg head{};
  head.ifi_index = ifindex;
  const auto answer = kernel_.get(new_message(RTM_GETLINK, 0, &head, sizeof head));
  if (!answer) return answer.error().when("reading the counters of an interface");
  std::optional<Traffic> found;
  answer->each_object(RTM_NEWLINK, [&found](nl_object* object) {
    auto* link = reinterpret_cast<rtnl_link*>(object);  // NOLINT(*-reinterpret-cast)
    found = Traffic{rtnl_link_get_stat(link, RTNL_LINK_TX_PACKETS),
                    rtnl_link_get_stat(link, RTNL_LINK_TX_BYTES),
                    rtnl_link_get_stat(link, RTNL_LINK_RX_PACKETS),
                    rtnl_link_get_stat(link, RTNL_LINK_RX_BYTES),
                    rtnl_link_get_stat(link, RTNL_LINK_TX_DROPPED)};
  });
  if (!found) return fail("the kernel did not say what an interface has counted");
  return *found;
}

Result<void> Links::set_bitrates(int ifindex, std::uint32_t bitrate, std::uint32_t data_bitrate) {
  const LinkObject change(rtnl_link_alloc());
  if (!change) throw std::bad_alloc();
  rtnl_link_set_ifindex(change.get(), ifindex);
  rtnl_link_set_type(change.get(), "can");
  if (bitrate != 0) rtnl_link_can_set_bitrate(change.get(), bitrate);
  if (data_bitrate != 0) {
    can_bittiming timing{};
    timing.bitrate = data_bitrate;
    rtnl_link_can_set_data_bittiming(change.get(), &timing);
    rtnl_link_can_set_ctrlmode(change.get(), CAN_CTRLMODE_FD);
  }
  nl_msg* raw = nullptr;
  if (const int e = rtnl_link_build_change_request(change.get(), change.get(), 0, &raw); e < 0)
    return fail(std::string("a bit rate: ") + nl_geterror(e));
  const Message request(raw);
  if (const auto done = kernel_.change(request); !done)
    return done.error().when("setting a bit rate of " + std::to_string(bitrate));
  return {};
}

Result<void> Links::set_up(int ifindex, bool up) {
  ifinfomsg head{};
  head.ifi_index = ifindex;
  head.ifi_flags = up ? IFF_UP : 0;
  head.ifi_change = IFF_UP;
  if (const auto done = kernel_.change(new_message(RTM_NEWLINK, 0, &head, sizeof head)); !done)
    return done.error().when(up ? "bringing the interface up" : "taking the interface down");
  return {};
}

}  // namespace mlcca::net
