// SPDX-License-Identifier: BSD-2-Clause
// The kernel lists filters in the order in which they run.
#include "daemon/net/filters.hpp"

#include <linux/pkt_cls.h>
#include <linux/pkt_sched.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <netlink/netlink.h>
#include <netlink/route/qdisc.h>
#include <netlink/route/tc.h>
#include <netlink/socket.h>

#include <algorithm>
#include <array>
#include <memory>

#include "core/handle.hpp"

namespace mlcca::net {
namespace {

using Socket = std::unique_ptr<nl_sock, FreeWith<nl_socket_free>>;
using Cache = std::unique_ptr<nl_cache, FreeWith<nl_cache_free>>;
using Qdisc = std::unique_ptr<rtnl_qdisc, FreeWith<rtnl_qdisc_put>>;

constexpr std::uint32_t kPriorityShift = 16;

std::unexpected<Error> netlink_error(const std::string& call, int error) {
  return fail(call + ": " + nl_geterror(error));
}

Result<Socket> connect() {
  Socket socket(nl_socket_alloc());
  if (!socket) return fail("nl_socket_alloc: out of memory");
  if (const int e = nl_connect(socket.get(), NETLINK_ROUTE); e < 0)
    return netlink_error("rtnetlink", e);
  return socket;
}

int collect(nl_msg* message, void* list) noexcept {
  nlmsghdr* head = nlmsg_hdr(message);
  if (head->nlmsg_type != RTM_NEWTFILTER) return NL_OK;
  std::array<nlattr*, TCA_MAX + 1> attributes{};
  if (nlmsg_parse(head, sizeof(tcmsg), attributes.data(), TCA_MAX, nullptr) < 0) return NL_SKIP;
  if (attributes[TCA_CHAIN] != nullptr && nla_get_u32(attributes[TCA_CHAIN]) != 0) return NL_OK;
  const auto* tc = static_cast<const tcmsg*>(nlmsg_data(head));
  // A classifier of some kinds is listed before its filters, with no handle.
  if (tc->tcm_handle == 0) return NL_OK;
  Filter filter;
  filter.priority = tc->tcm_info >> kPriorityShift;
  filter.handle = tc->tcm_handle;
  if (attributes[TCA_KIND] != nullptr) filter.kind = nla_get_string(attributes[TCA_KIND]);
  if (filter.kind == "bpf" && attributes[TCA_OPTIONS] != nullptr) {
    std::array<nlattr*, TCA_BPF_MAX + 1> bpf{};
    if (nla_parse_nested(bpf.data(), TCA_BPF_MAX, attributes[TCA_OPTIONS], nullptr) == 0) {
      if (bpf[TCA_BPF_NAME] != nullptr) filter.name = nla_get_string(bpf[TCA_BPF_NAME]);
      if (bpf[TCA_BPF_ID] != nullptr) filter.program = nla_get_u32(bpf[TCA_BPF_ID]);
    }
  }
  static_cast<std::vector<Filter>*>(list)->push_back(std::move(filter));
  return NL_OK;
}

}  // namespace

Result<std::vector<Filter>> all_filters(int ifindex, bool ingress) {
  const auto socket = connect();
  if (!socket) return std::unexpected(socket.error());
  std::vector<Filter> filters;
  nl_socket_modify_cb(socket->get(), NL_CB_VALID, NL_CB_CUSTOM, collect, &filters);
  tcmsg request{};
  request.tcm_ifindex = ifindex;
  request.tcm_parent = TC_H_MAKE(TC_H_CLSACT, ingress ? TC_H_MIN_INGRESS : TC_H_MIN_EGRESS);
  int e = nl_send_simple(socket->get(), RTM_GETTFILTER, NLM_F_DUMP, &request, sizeof(request));
  if (e >= 0) e = nl_recvmsgs_default(socket->get());
  if (e < 0) return netlink_error("reading the filters of an interface", e);
  return filters;
}

Result<std::vector<Filter>> filters_before(int ifindex, bool ingress, std::uint32_t priority,
                                           std::uint32_t handle) {
  auto filters = all_filters(ifindex, ingress);
  if (!filters) return filters;
  filters->erase(
      std::ranges::find_if(
          *filters, [&](const Filter& f) { return f.priority == priority && f.handle == handle; }),
      filters->end());
  return filters;
}

Result<Waiting> waiting_in_queue(int ifindex) {
  const auto socket = connect();
  if (!socket) return std::unexpected(socket.error());
  nl_cache* raw = nullptr;
  if (const int e = rtnl_qdisc_alloc_cache(socket->get(), &raw); e < 0)
    return netlink_error("reading the queueing disciplines", e);
  const Cache cache(raw);
  const Qdisc root(rtnl_qdisc_get_by_parent(cache.get(), ifindex, TC_H_ROOT));
  if (!root) return Waiting{};
  // NOLINTNEXTLINE(*-reinterpret-cast): every qdisc is a tc object
  auto* tc = reinterpret_cast<rtnl_tc*>(root.get());
  return Waiting{.frames = rtnl_tc_get_stat(tc, RTNL_TC_QLEN),
                 .dropped = rtnl_tc_get_stat(tc, RTNL_TC_DROPS)};
}

}  // namespace mlcca::net
