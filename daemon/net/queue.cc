// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/queue.hpp"

#include <netlink/errno.h>
#include <netlink/route/qdisc/prio.h>

#include <array>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <string_view>

#include "daemon/net/root_queue.hpp"

namespace mlcca::net {
namespace {

using Qdisc = std::unique_ptr<rtnl_qdisc, FreeWith<rtnl_qdisc_put>>;

constexpr std::uint32_t kHandle = 0x4d4c0000;  // "ML"
constexpr std::size_t kPriorities = TC_PRIO_MAX + 1;

std::unexpected<Error> netlink_error(const std::string& call, int error) {
  return fail(call + ": " + nl_geterror(error));
}

/// Whether the root discipline is ours.
Result<bool> is_there(Rtnl& kernel, int ifindex) {
  bool ours = false;
  const auto read = with_root_queue(kernel, ifindex, [&ours](rtnl_qdisc*, rtnl_tc* tc) {
    const char* kind = rtnl_tc_get_kind(tc);
    ours = kind != nullptr && std::string_view(kind) == "prio" && rtnl_tc_get_handle(tc) == kHandle;
  });
  if (!read) return std::unexpected(read.error());
  return ours;
}

}  // namespace

Result<bool> keep_priority_queue(int ifindex) {
  Rtnl kernel;
  const auto there = is_there(kernel, ifindex);
  if (!there) return std::unexpected(there.error());
  if (*there) return true;

  const Qdisc prio(rtnl_qdisc_alloc());
  if (!prio) throw std::bad_alloc();
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
  nl_msg* raw = nullptr;
  if (const int e = rtnl_qdisc_build_add_request(prio.get(), NLM_F_CREATE | NLM_F_REPLACE, &raw);
      e < 0)
    return netlink_error("a priority queue", e);
  const Message request(raw);
  if (const auto done = kernel.change(request); !done)
    return done.error().when("setting up a priority queue");
  return false;
}

}  // namespace mlcca::net
