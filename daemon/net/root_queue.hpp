// SPDX-License-Identifier: BSD-2-Clause
// The root queueing discipline of an interface.
#pragma once
#include <linux/pkt_sched.h>
#include <linux/rtnetlink.h>
#include <netlink/route/qdisc.h>
#include <netlink/route/tc.h>

#include "daemon/net/rtnl.hpp"

namespace mlcca::net {

/// Calls `take` with the discipline; does not call it if there is none.
template <class Take>
Result<void> with_root_queue(Rtnl& kernel, int ifindex, Take&& take) {
  tcmsg head{};
  head.tcm_ifindex = ifindex;
  const auto answers = kernel.dump(new_message(RTM_GETQDISC, 0, &head, sizeof head));
  if (!answers) return answers.error().when("reading the queueing disciplines");
  answers->each_object(RTM_NEWQDISC, [&](nl_object* object) {
    // NOLINTBEGIN(*-reinterpret-cast): a qdisc is a tc object
    auto* tc = reinterpret_cast<rtnl_tc*>(object);
    if (rtnl_tc_get_ifindex(tc) == ifindex && rtnl_tc_get_parent(tc) == TC_H_ROOT)
      take(reinterpret_cast<rtnl_qdisc*>(object), tc);
    // NOLINTEND(*-reinterpret-cast)
  });
  return {};
}

}  // namespace mlcca::net
