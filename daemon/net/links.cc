// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/links.hpp"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <netlink/netlink.h>
#include <netlink/route/link.h>
#include <netlink/route/link/can.h>
#include <netlink/socket.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>

#include "core/handle.hpp"

namespace mlcca::net {
namespace {

using LinkObject = std::unique_ptr<rtnl_link, FreeWith<rtnl_link_put>>;
using Cache = std::unique_ptr<nl_cache, FreeWith<nl_cache_free>>;

std::unexpected<Error> netlink_error(const std::string& call, int error) {
  return fail(call + ": " + nl_geterror(error));
}

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
  out.up = (rtnl_link_get_flags(link) & IFF_UP) != 0;
  if (rtnl_link_is_can(link) == 0) return out;
  std::uint32_t value = 0;
  if (rtnl_link_can_state(link, &value) == 0) out.can_state = can_state_name(value);
  if (rtnl_link_can_get_bitrate(link, &value) == 0) out.bitrate = value;
  can_bittiming timing{};
  if (rtnl_link_can_get_data_bittiming(link, &timing) == 0) out.data_bitrate = timing.bitrate;
  return out;
}

}  // namespace

void Links::FreeSocket::operator()(nl_sock* socket) const noexcept { nl_socket_free(socket); }

Links::Links(Socket notices, Socket requests)
    : notices_(std::move(notices)), requests_(std::move(requests)) {}
Links::Links(Links&&) noexcept = default;
Links& Links::operator=(Links&&) noexcept = default;
Links::~Links() = default;

Result<Links> Links::open() {
  Socket notices(nl_socket_alloc());
  Socket requests(nl_socket_alloc());
  if (!notices || !requests) return fail("nl_socket_alloc: out of memory");
  nl_socket_disable_seq_check(notices.get());
  for (nl_sock* socket : {notices.get(), requests.get()})
    if (const int e = nl_connect(socket, NETLINK_ROUTE); e < 0)
      return netlink_error("rtnetlink", e);
  for (const int group : {RTNLGRP_LINK, RTNLGRP_TC})
    if (const int e = nl_socket_add_membership(notices.get(), group); e < 0)
      return netlink_error("rtnetlink notifications", e);
  if (const int e = nl_socket_set_nonblocking(notices.get()); e < 0)
    return netlink_error("rtnetlink", e);
  Links links(std::move(notices), std::move(requests));
  if (auto table = links.read(); table)
    links.table_ = std::move(*table);
  else
    return std::unexpected(table.error());
  return links;
}

int Links::fd() const { return nl_socket_get_fd(notices_.get()); }

Result<LinkTable> Links::read() {
  nl_cache* raw = nullptr;
  if (const int e = rtnl_link_alloc_cache(requests_.get(), AF_UNSPEC, &raw); e < 0)
    return netlink_error("reading the interfaces", e);
  const Cache cache(raw);
  LinkTable table;
  for (nl_object* o = nl_cache_get_first(cache.get()); o != nullptr; o = nl_cache_get_next(o)) {
    // Every object of a link cache is a link.
    Link link = describe(reinterpret_cast<rtnl_link*>(o));  // NOLINT(*-reinterpret-cast)
    table.emplace(link.ifindex, std::move(link));
  }
  return table;
}

Result<bool> Links::refresh() {
  // What the notifications say of links is read from the table; an overflow (ENOBUFS) is just one
  // of them.
  alignas(nlmsghdr) std::array<char, 32768> notices{};
  for (;;) {
    const ssize_t size = ::recv(fd(), notices.data(), notices.size(), 0);
    if (size >= 0) {
      take_notices(notices.data(), static_cast<std::size_t>(size));
      continue;
    }
    if (errno == ENOBUFS) tc_changed_ = true;
    if (errno != ENOBUFS && errno != EINTR) break;
  }
  auto table = read();
  if (!table) return std::unexpected(table.error());
  const bool changed = *table != table_;
  table_ = std::move(*table);
  return changed;
}

void Links::take_notices(const char* notices, std::size_t size) {
  auto left = static_cast<int>(size);
  // NOLINTBEGIN(*-cstyle-cast,*-reinterpret-cast): macros of the kernel's header
  for (const auto* head = reinterpret_cast<const nlmsghdr*>(notices); NLMSG_OK(head, left);
       head = NLMSG_NEXT(head, left)) {
    const int type = head->nlmsg_type;
    if (type >= RTM_NEWQDISC && type <= RTM_GETTFILTER) tc_changed_ = true;
    if (type != RTM_DELLINK) continue;
    const auto* info = static_cast<const ifinfomsg*>(NLMSG_DATA(head));
    const auto attribute = [head](int type_of_it) {
      return nlmsg_find_attr(const_cast<nlmsghdr*>(head), sizeof(ifinfomsg), type_of_it);
    };
    auto* name = attribute(IFLA_IFNAME);
    // By the message alone: the table may have been read when the link was already gone.
    if (name != nullptr && attribute(IFLA_NEW_NETNSID) != nullptr)
      moved_.push_back({info->ifi_index, nla_get_string(name)});
  }
  // NOLINTEND(*-cstyle-cast,*-reinterpret-cast)
}

Result<Traffic> Links::traffic(int ifindex) {
  rtnl_link* raw = nullptr;
  if (const int e = rtnl_link_get_kernel(requests_.get(), ifindex, nullptr, &raw); e < 0)
    return netlink_error("reading the counters of an interface", e);
  const LinkObject link(raw);
  return Traffic{
      rtnl_link_get_stat(raw, RTNL_LINK_TX_PACKETS), rtnl_link_get_stat(raw, RTNL_LINK_TX_BYTES),
      rtnl_link_get_stat(raw, RTNL_LINK_RX_PACKETS), rtnl_link_get_stat(raw, RTNL_LINK_RX_BYTES),
      rtnl_link_get_stat(raw, RTNL_LINK_TX_DROPPED)};
}

Result<void> Links::set_bitrates(int ifindex, std::uint32_t bitrate, std::uint32_t data_bitrate) {
  const LinkObject change(rtnl_link_alloc());
  if (!change) return fail("rtnl_link_alloc: out of memory");
  rtnl_link_set_ifindex(change.get(), ifindex);
  rtnl_link_set_type(change.get(), "can");
  if (bitrate != 0) rtnl_link_can_set_bitrate(change.get(), bitrate);
  if (data_bitrate != 0) {
    can_bittiming timing{};
    timing.bitrate = data_bitrate;
    rtnl_link_can_set_data_bittiming(change.get(), &timing);
    rtnl_link_can_set_ctrlmode(change.get(), CAN_CTRLMODE_FD);
  }
  if (const int e = rtnl_link_change(requests_.get(), change.get(), change.get(), 0); e < 0)
    return netlink_error("setting a bit rate of " + std::to_string(bitrate), e);
  return {};
}

Result<void> Links::set_up(int ifindex, bool up) {
  const LinkObject change(rtnl_link_alloc());
  if (!change) return fail("rtnl_link_alloc: out of memory");
  rtnl_link_set_ifindex(change.get(), ifindex);
  if (up)
    rtnl_link_set_flags(change.get(), IFF_UP);
  else
    rtnl_link_unset_flags(change.get(), IFF_UP);
  if (const int e = rtnl_link_change(requests_.get(), change.get(), change.get(), 0); e < 0)
    return netlink_error(up ? "bringing the interface up" : "taking the interface down", e);
  return {};
}

}  // namespace mlcca::net
