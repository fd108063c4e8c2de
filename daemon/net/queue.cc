// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/queue.hpp"

#include <netlink/netlink.h>
#include <netlink/route/qdisc.h>
#include <netlink/route/qdisc/prio.h>
#include <netlink/route/tc.h>
#include <netlink/socket.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/handle.hpp"

namespace mlcca::net {
namespace {

using Socket = std::unique_ptr<nl_sock, FreeWith<nl_socket_free>>;
using Cache = std::unique_ptr<nl_cache, FreeWith<nl_cache_free>>;
using Qdisc = std::unique_ptr<rtnl_qdisc, FreeWith<rtnl_qdisc_put>>;

constexpr std::uint32_t kHandle = 0x4d4c0000;  // "ML"
constexpr std::size_t kPriorities = TC_PRIO_MAX + 1;

std::unexpected<Error> netlink_error(const std::string& call, int error) {
  return fail(call + ": " + nl_geterror(error));
}

/// The discipline at the root is ours.
Result<bool> is_there(nl_sock* socket, int ifindex) {
  nl_cache* raw = nullptr;
  if (const int e = rtnl_qdisc_alloc_cache(socket, &raw); e < 0)
    return netlink_error("reading the queueing disciplines", e);
  const Cache cache(raw);
  const Qdisc root(rtnl_qdisc_get_by_parent(cache.get(), ifindex, TC_H_ROOT));
  if (!root) return false;
  // NOLINTNEXTLINE(*-reinterpret-cast): every qdisc is a tc object
  const auto* tc = reinterpret_cast<rtnl_tc*>(root.get());
  const char* kind = rtnl_tc_get_kind(const_cast<rtnl_tc*>(tc));  // NOLINT(*-const-cast)
  return kind != nullptr && std::string_view(kind) == "prio" &&
         rtnl_tc_get_handle(const_cast<rtnl_tc*>(tc)) == kHandle;  // NOLINT(*-const-cast)
}

}  // namespace

Result<bool> keep_priority_queue(int ifindex) {
  const Socket socket(nl_socket_alloc());
  if (!socket) return fail("nl_socket_alloc: out of memory");
  if (const int e = nl_connect(socket.get(), NETLINK_ROUTE); e < 0)
    return netlink_error("rtnetlink", e);
  const auto there = is_there(socket.get(), ifindex);
  if (!there) return std::unexpected(there.error());
  if (*there) return true;

  const Qdisc prio(rtnl_qdisc_alloc());
  if (!prio) return fail("rtnl_qdisc_alloc: out of memory");
  // NOLINTNEXTLINE(*-reinterpret-cast): every qdisc is a tc object
  auto* tc = reinterpret_cast<rtnl_tc*>(prio.get());
  rtnl_tc_set_ifindex(tc, ifindex);
  rtnl_tc_set_parent(tc, TC_H_ROOT);
  rtnl_tc_set_handle(tc, kHandle);
  if (const int e = rtnl_tc_set_kind(tc, "prio"); e < 0) return netlink_error("prio", e);
  rtnl_qdisc_prio_set_bands(prio.get(), kQueueBands);
  std::array<std::uint8_t, kPriorities> map{};
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<std::uint8_t>(i);
  if (const int e =
          rtnl_qdisc_prio_set_priomap(prio.get(), map.data(), static_cast<int>(map.size()));
      e < 0)
    return netlink_error("the bands of a priority queue", e);
  if (const int e = rtnl_qdisc_add(socket.get(), prio.get(), NLM_F_CREATE | NLM_F_REPLACE); e < 0)
    return netlink_error("setting up a priority queue", e);
  return false;
}

}  // namespace mlcca::net
