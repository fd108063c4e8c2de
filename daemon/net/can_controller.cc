// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/can_controller.hpp"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/ethtool.h>
#include <linux/if.h>
#include <linux/sockios.h>
#include <netlink/route/link.h>
#include <netlink/route/link/can.h>
#include <netlink/route/qdisc/fifo.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <string_view>

#include "base/handle.hpp"
#include "daemon/net/root_queue.hpp"

namespace mlcca::net {
namespace {

/// Empty if the kernel has no name for it.
std::string driver_of(std::string_view interface) {
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ethtool_drvinfo info{};
  info.cmd = ETHTOOL_GDRVINFO;
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  request.ifr_data = reinterpret_cast<char*>(&info);  // NOLINT(*-reinterpret-cast)
  if (::ioctl(socket.get(), SIOCETHTOOL, &request) < 0) return {};
  info.driver[sizeof info.driver - 1] = '\0';
  return info.driver;
}

void take_can(rtnl_link* link, CanController& out) {
  std::uint32_t value = 0;
  if (rtnl_link_can_get_ctrlmode(link, &value) == 0) out.modes = value;
  if (rtnl_link_can_freq(link, &value) == 0) out.clock = value;
  if (rtnl_link_can_get_restart_ms(link, &value) == 0) out.restart_ms = value;
  if (rtnl_link_can_get_sample_point(link, &value) == 0) out.sample_point = value;
  can_bittiming timing{};
  if (rtnl_link_can_get_data_bittiming(link, &timing) == 0)
    out.data_sample_point = timing.sample_point;
  can_berr_counter errors{};
  if (rtnl_link_can_berr(link, &errors) == 0)
    out.errors = ErrorCounters{.sending = errors.txerr, .receiving = errors.rxerr};
}

Result<void> take_queue(Rtnl& kernel, CanController& out) {
  return with_root_queue(kernel, out.ifindex, [&out](rtnl_qdisc* root, rtnl_tc* tc) {
    const char* kind = rtnl_tc_get_kind(tc);
    out.queue = kind == nullptr ? "" : kind;
    // Each band of prio has a limit of the same size.
    if (out.queue == "pfifo_fast" || out.queue == "prio") out.queue_limit = out.queue_length;
    if (out.queue != "pfifo") return;
    const int limit = rtnl_qdisc_fifo_get_limit(root);
    out.queue_limit = static_cast<std::uint32_t>(std::max(limit, 0));
  });
}

CanController read_link(rtnl_link* link) {
  CanController out;
  out.echoes = (rtnl_link_get_flags(link) & IFF_ECHO) != 0;
  out.fd = rtnl_link_get_mtu(link) >= CANFD_MTU;
  out.queue_length = rtnl_link_get_txqlen(link);
  if (const char* name = rtnl_link_get_name(link); name != nullptr) out.driver = driver_of(name);
  if (rtnl_link_is_can(link) != 0) take_can(link, out);
  return out;
}

}  // namespace

Result<CanController> read_controller(int ifindex) {
  Rtnl kernel;
  ifinfomsg head{};
  head.ifi_index = ifindex;
  const auto answer = kernel.get(new_message(RTM_GETLINK, 0, &head, sizeof head));
  if (!answer) return answer.error().when("reading an interface");
  CanController out;
  answer->each_object(RTM_NEWLINK, [&out](nl_object* object) {
    out = read_link(reinterpret_cast<rtnl_link*>(object));  // NOLINT(*-reinterpret-cast)
  });
  out.ifindex = ifindex;
  if (auto queue = take_queue(kernel, out); !queue) return std::unexpected(queue.error());
  return out;
}

}  // namespace mlcca::net
