// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/pair.hpp"

#include <fmt/format.h>
#include <linux/can/vxcan.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <linux/veth.h>
#include <net/if.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <netlink/netlink.h>
#include <netlink/socket.h>

#include <memory>

#include "core/handle.hpp"

namespace mlcca::net {
namespace {

using Socket = std::unique_ptr<nl_sock, FreeWith<nl_socket_free>>;
using Message = std::unique_ptr<nl_msg, FreeWith<nlmsg_free>>;

static_assert(int{VXCAN_INFO_PEER} == int{VETH_INFO_PEER});

bool put_end(nl_msg* message, const End& end) {
  ifinfomsg head{};
  head.ifi_index = end.ifindex;
  return nlmsg_append(message, &head, sizeof head, NLMSG_ALIGNTO) == 0 &&
         nla_put_string(message, IFLA_IFNAME, end.name.c_str()) == 0;
}

bool put_pair(nl_msg* message, const char* kind, const End& near, const End& far) {
  if (!put_end(message, near)) return false;
  nlattr* const info = nla_nest_start(message, IFLA_LINKINFO);
  if (info == nullptr || nla_put_string(message, IFLA_INFO_KIND, kind) != 0) return false;
  nlattr* const data = nla_nest_start(message, IFLA_INFO_DATA);
  nlattr* const peer = data != nullptr ? nla_nest_start(message, VXCAN_INFO_PEER) : nullptr;
  if (peer == nullptr || !put_end(message, far)) return false;
  nla_nest_end(message, peer);
  nla_nest_end(message, data);
  nla_nest_end(message, info);
  return true;
}

int ask(nl_sock* socket, nl_msg* message) {
  const int sent = nl_send_auto(socket, message);
  return sent < 0 ? sent : nl_wait_for_ack(socket);
}

/// Not while it is made: an end cannot be up before its other end is there.
int bring_up(nl_sock* socket, const End& end) {
  const Message message(nlmsg_alloc_simple(RTM_NEWLINK, 0));
  ifinfomsg head{};
  head.ifi_index = end.ifindex;
  head.ifi_flags = IFF_UP;
  head.ifi_change = IFF_UP;
  if (!message || nlmsg_append(message.get(), &head, sizeof head, NLMSG_ALIGNTO) != 0)
    return -NLE_NOMEM;
  return ask(socket, message.get());
}

}  // namespace

Result<void> make_pair(const char* kind, const End& near, const End& far) {
  const Socket socket(nl_socket_alloc());
  const Message message(nlmsg_alloc_simple(RTM_NEWLINK, NLM_F_CREATE | NLM_F_EXCL));
  if (!socket || !message || !put_pair(message.get(), kind, near, far))
    return fail("no memory for a netlink message");
  int error = nl_connect(socket.get(), NETLINK_ROUTE);
  if (error == 0) error = ask(socket.get(), message.get());
  if (error == 0) error = bring_up(socket.get(), near);
  if (error == 0) error = bring_up(socket.get(), far);
  if (error != 0)
    return fail(fmt::format("a {} pair as {}: {}", kind, near.name, nl_geterror(error)));
  return {};
}

}  // namespace mlcca::net
