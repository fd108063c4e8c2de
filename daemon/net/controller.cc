// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/controller.hpp"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/ethtool.h>
#include <linux/if.h>
#include <linux/sockios.h>
#include <netlink/netlink.h>
#include <netlink/route/link.h>
#include <netlink/route/link/can.h>
#include <netlink/route/qdisc.h>
#include <netlink/route/qdisc/fifo.h>
#include <netlink/route/tc.h>
#include <netlink/socket.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <string_view>

#include "core/handle.hpp"

namespace mlcca::net {
namespace {

using Socket = std::unique_ptr<nl_sock, FreeWith<nl_socket_free>>;
using Cache = std::unique_ptr<nl_cache, FreeWith<nl_cache_free>>;
using LinkObject = std::unique_ptr<rtnl_link, FreeWith<rtnl_link_put>>;
using Qdisc = std::unique_ptr<rtnl_qdisc, FreeWith<rtnl_qdisc_put>>;

std::unexpected<Error> netlink_error(const std::string& call, int error) {
  return fail(call + ": " + nl_geterror(error));
}

/// Empty where the kernel has no name for it.
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

void take_can(rtnl_link* link, Controller& out) {
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

Result<void> take_queue(nl_sock* socket, Controller& out) {
  nl_cache* raw = nullptr;
  if (const int e = rtnl_qdisc_alloc_cache(socket, &raw); e < 0)
    return netlink_error("reading the queueing disciplines", e);
  const Cache cache(raw);
  const Qdisc root(rtnl_qdisc_get_by_parent(cache.get(), out.ifindex, TC_H_ROOT));
  if (!root) return {};
  // NOLINTNEXTLINE(*-reinterpret-cast): every qdisc is a tc object
  const char* kind = rtnl_tc_get_kind(reinterpret_cast<rtnl_tc*>(root.get()));
  out.queue = kind == nullptr ? "" : kind;
  // The bands of prio are made with such a limit each.
  if (out.queue == "pfifo_fast" || out.queue == "prio") out.queue_limit = out.queue_length;
  if (out.queue == "pfifo") {
    const int limit = rtnl_qdisc_fifo_get_limit(root.get());
    out.queue_limit = static_cast<std::uint32_t>(std::max(limit, 0));
  }
  return {};
}

}  // namespace

Result<Controller> read_controller(int ifindex) {
  const Socket socket(nl_socket_alloc());
  if (!socket) return fail("nl_socket_alloc: out of memory");
  if (const int e = nl_connect(socket.get(), NETLINK_ROUTE); e < 0)
    return netlink_error("rtnetlink", e);
  rtnl_link* raw = nullptr;
  if (const int e = rtnl_link_get_kernel(socket.get(), ifindex, nullptr, &raw); e < 0)
    return netlink_error("reading an interface", e);
  const LinkObject link(raw);
  Controller out;
  out.ifindex = ifindex;
  out.echoes = (rtnl_link_get_flags(raw) & IFF_ECHO) != 0;
  out.fd = rtnl_link_get_mtu(raw) >= CANFD_MTU;
  out.queue_length = rtnl_link_get_txqlen(raw);
  if (const char* name = rtnl_link_get_name(raw); name != nullptr) out.driver = driver_of(name);
  if (rtnl_link_is_can(raw) != 0) take_can(raw, out);
  if (auto queue = take_queue(socket.get(), out); !queue) return std::unexpected(queue.error());
  return out;
}

}  // namespace mlcca::net
