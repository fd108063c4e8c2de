// SPDX-License-Identifier: BSD-2-Clause
// The kernel lists filters in the order in which they run.
#include "daemon/net/filter_order.hpp"

#include <linux/pkt_cls.h>
#include <linux/pkt_sched.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>

#include <algorithm>
#include <array>

#include "daemon/net/root_queue.hpp"

namespace mlcca::net {
namespace {

constexpr std::uint32_t kPriorityShift = 16;

void collect(const nlmsghdr& message, std::vector<Filter>& list) {
  if (message.nlmsg_type != RTM_NEWTFILTER) return;
  std::array<nlattr*, TCA_MAX + 1> attributes{};
  if (nlmsg_parse(const_cast<nlmsghdr*>(&message), sizeof(tcmsg),  // NOLINT(*-const-cast)
                  attributes.data(), TCA_MAX, nullptr) < 0)
    return;
  if (attributes[TCA_CHAIN] != nullptr && number_in(*attributes[TCA_CHAIN]) != 0) return;
  const auto* tc = static_cast<const tcmsg*>(nlmsg_data(&message));
  // Some kinds of classifier are listed before their filters, without a handle.
  if (tc->tcm_handle == 0) return;
  Filter filter;
  filter.priority = tc->tcm_info >> kPriorityShift;
  filter.handle = tc->tcm_handle;
  if (attributes[TCA_KIND] != nullptr) filter.kind = text_in(*attributes[TCA_KIND]);
  if (filter.kind == "bpf" && attributes[TCA_OPTIONS] != nullptr) {
    std::array<nlattr*, TCA_BPF_MAX + 1> bpf{};
    if (nla_parse_nested(bpf.data(), TCA_BPF_MAX, attributes[TCA_OPTIONS], nullptr) == 0) {
      if (bpf[TCA_BPF_NAME] != nullptr) filter.name = text_in(*bpf[TCA_BPF_NAME]);
      if (bpf[TCA_BPF_ID] != nullptr) filter.program = number_in(*bpf[TCA_BPF_ID]);
    }
  }
  list.push_back(std::move(filter));
}

}  // namespace

Result<std::vector<Filter>> all_filters(int ifindex, bool ingress) {
  tcmsg head{};
  head.tcm_ifindex = ifindex;
  head.tcm_parent = TC_H_MAKE(TC_H_CLSACT, ingress ? TC_H_MIN_INGRESS : TC_H_MIN_EGRESS);
  const auto answers = Rtnl().dump(new_message(RTM_GETTFILTER, 0, &head, sizeof head));
  if (!answers) return answers.error().when("reading the filters of an interface");
  std::vector<Filter> filters;
  answers->each([&filters](const nlmsghdr& message) { collect(message, filters); });
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
  Rtnl kernel;
  Waiting out;
  const auto read = with_root_queue(kernel, ifindex, [&out](rtnl_qdisc*, rtnl_tc* tc) {
    out = {.frames = rtnl_tc_get_stat(tc, RTNL_TC_QLEN),
           .dropped = rtnl_tc_get_stat(tc, RTNL_TC_DROPS)};
  });
  if (!read) return std::unexpected(read.error());
  return out;
}

}  // namespace mlcca::net
