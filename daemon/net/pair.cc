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

#include "daemon/net/rtnl.hpp"

namespace mlcca::net {
namespace {

static_assert(int{VXCAN_INFO_PEER} == int{VETH_INFO_PEER});

/// The attributes of the other end.
bool put_end(nl_msg* message, const End& end) {
  ifinfomsg head{};
  head.ifi_index = end.ifindex;
  return nlmsg_append(message, &head, sizeof head, NLMSG_ALIGNTO) == 0 &&
         nla_put_string(message, IFLA_IFNAME, end.name.c_str()) == 0;
}

bool put_pair(nl_msg* message, const char* kind, const End& near, const End& far) {
  if (nla_put_string(message, IFLA_IFNAME, near.name.c_str()) != 0) return false;
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

/// Brings an end up after the pair was made, because an end cannot be up before its other end
/// exists.
std::expected<void, Refusal> bring_up(Rtnl& kernel, const End& end) {
  ifinfomsg head{};
  head.ifi_index = end.ifindex;
  head.ifi_flags = IFF_UP;
  head.ifi_change = IFF_UP;
  return kernel.change(new_message(RTM_NEWLINK, 0, &head, sizeof head));
}

}  // namespace

Result<void> make_pair(const char* kind, const End& near, const End& far) {
  ifinfomsg head{};
  head.ifi_index = near.ifindex;
  const Message message = new_message(RTM_NEWLINK, NLM_F_CREATE | NLM_F_EXCL, &head, sizeof head);
  if (!put_pair(message.get(), kind, near, far)) return fail("a pair of interfaces does not fit");
  Rtnl kernel;
  auto done = kernel.change(message);
  if (done) done = bring_up(kernel, near);
  if (done) done = bring_up(kernel, far);
  if (!done) return done.error().when(fmt::format("a {} pair as {}", kind, near.name));
  return {};
}

}  // namespace mlcca::net
