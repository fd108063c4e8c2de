// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/can_routes.hpp"

#include <linux/can/gw.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

namespace mlcca::net {
namespace {

// The flag lets a frame leave by the interface index on which it came in: an interface with the
// same index in another network namespace (vxcan) may have sent it. Local listeners of the egress
// interface do not get these frames, which they would take for frames from that bus. The gates keep
// a frame from returning to where it came from.
constexpr std::uint16_t kFlags = CGW_FLAGS_CAN_IIF_TX_OK;

using Attributes = std::array<nlattr*, CGW_MAX + 1>;

std::unexpected<Error> refused(const std::string& call, const Refusal& why) {
  if (why.said == EOPNOTSUPP) return fail(call + ": the kernel has no can-gw: modprobe can-gw");
  if (why.said == EPERM) return fail(call + ": not permitted: CAP_NET_ADMIN is needed");
  return why.when(call);
}

/// Both frames and FD frames begin with the identifier, and end with the kind of change.
template <class Change>
bool put_change(nl_msg* message, int type, std::uint32_t can_id) {
  Change change{};
  change.cf.can_id = can_id;
  change.modtype = CGW_MOD_ID;
  return nla_put(message, type, sizeof change, &change) == 0;
}

bool put_changes(nl_msg* message, const CanRule& rule) {
  const auto put = [&](int classic, int fd, std::uint32_t can_id) {
    return rule.fd ? put_change<cgw_fdframe_mod>(message, fd, can_id)
                   : put_change<cgw_frame_mod>(message, classic, can_id);
  };
  if (rule.keep != ~0U && !put(CGW_MOD_AND, CGW_FDMOD_AND, rule.keep)) return false;
  return put(CGW_MOD_OR, CGW_FDMOD_OR, rule.set);
}

Result<Message> message_of(int type, const CanRuleThere& there) {
  const CanRule& rule = there.rule;
  if (rule.from <= 0 || rule.to <= 0) return fail("a can-gw rule needs two interfaces");
  if (!there.is_ours()) return fail("a can-gw rule of another program is left alone");
  const rtcanmsg head{AF_CAN, CGW_TYPE_CAN_CAN, there.flags};
  Message message = new_message(type, NLM_F_REQUEST | NLM_F_ACK, &head, sizeof head);
  const can_filter filter{rule.id, rule.mask};
  nl_msg* const m = message.get();
  const bool fits = nla_put_u32(m, CGW_SRC_IF, static_cast<std::uint32_t>(rule.from)) == 0 &&
                    nla_put_u32(m, CGW_DST_IF, static_cast<std::uint32_t>(rule.to)) == 0 &&
                    nla_put(m, CGW_FILTER, sizeof filter, &filter) == 0 && put_changes(m, rule) &&
                    nla_put_u32(m, CGW_MOD_UID, there.uid) == 0;
  if (!fits) return fail("a message for can-gw does not fit");
  return message;
}

template <class T>
bool read(const nlattr* attribute, T& to) {
  if (attribute == nullptr || nla_len(attribute) < static_cast<int>(sizeof to)) return false;
  std::memcpy(&to, nla_data(attribute), sizeof to);
  return true;
}

std::uint64_t number(const nlattr* attribute) {
  std::uint32_t value = 0;
  read(attribute, value);
  return value;
}

/// The identifier of a change that changes nothing else. False for any other change.
template <class Change>
bool read_id(const nlattr* attribute, std::uint32_t& id) {
  Change change{};
  if (!read(attribute, change) || change.modtype != CGW_MOD_ID) return false;
  id = change.cf.can_id;
  return true;
}

void read_changes(const Attributes& a, CanRuleThere& to) {
  const auto one = [&](int classic, int fd, std::uint32_t& id) {
    if (a[classic] != nullptr && !read_id<cgw_frame_mod>(a[classic], id)) to.changes_more = true;
    if (a[fd] != nullptr && !read_id<cgw_fdframe_mod>(a[fd], id)) to.changes_more = true;
  };
  one(CGW_MOD_AND, CGW_FDMOD_AND, to.rule.keep);
  one(CGW_MOD_OR, CGW_FDMOD_OR, to.rule.set);
  for (const int other :
       {CGW_MOD_XOR, CGW_MOD_SET, CGW_FDMOD_XOR, CGW_FDMOD_SET, CGW_CS_XOR, CGW_CS_CRC8})
    if (a[other] != nullptr) to.changes_more = true;
}

}  // namespace

CanRuleThere ours(const CanRule& rule, std::uint32_t uid) {
  CanRuleThere there;
  there.rule = rule;
  there.uid = uid;
  there.flags = static_cast<std::uint16_t>(kFlags | (rule.fd ? CGW_FLAGS_CAN_FD : 0));
  return there;
}

Result<Message> message_to_add(const CanRuleThere& rule) { return message_of(RTM_NEWROUTE, rule); }

Result<Message> message_to_remove(const CanRuleThere& rule) {
  return message_of(RTM_DELROUTE, rule);
}

void read_rule(const nlmsghdr& message, std::vector<CanRuleThere>& to) {
  // A kernel without can-gw answers with the routes of all other families.
  rtcanmsg head{};
  if (message.nlmsg_type != RTM_NEWROUTE || message.nlmsg_len < NLMSG_LENGTH(sizeof head)) return;
  std::memcpy(&head, nlmsg_data(&message), sizeof head);
  if (head.can_family != AF_CAN || head.gwtype != CGW_TYPE_CAN_CAN) return;
  Attributes a{};
  if (nla_parse(a.data(), CGW_MAX, nlmsg_attrdata(&message, sizeof head),
                nlmsg_attrlen(&message, sizeof head), nullptr) < 0)
    return;
  CanRuleThere there;
  there.flags = head.flags;
  there.rule.fd = (head.flags & CGW_FLAGS_CAN_FD) != 0;
  there.rule.from = static_cast<int>(number(a[CGW_SRC_IF]));
  there.rule.to = static_cast<int>(number(a[CGW_DST_IF]));
  if (there.rule.from <= 0 || there.rule.to <= 0) return;
  can_filter filter{};
  read(a[CGW_FILTER], filter);
  there.rule.id = filter.can_id;
  there.rule.mask = filter.can_mask;
  read_changes(a, there);
  there.uid = static_cast<std::uint32_t>(number(a[CGW_MOD_UID]));
  read(a[CGW_LIM_HOPS], there.hops);
  there.handled = number(a[CGW_HANDLED]);
  there.dropped = number(a[CGW_DROPPED]);
  there.deleted = number(a[CGW_DELETED]);
  to.push_back(there);
}

Result<std::vector<CanRuleThere>> KernelCanRules::read() {
  std::vector<CanRuleThere> rules;
  const rtcanmsg head{AF_CAN, 0, 0};
  const auto answers = rtnl_.dump(new_message(RTM_GETROUTE, 0, &head, sizeof head));
  if (!answers && answers.error().said == EOPNOTSUPP) return rules;
  if (!answers) return refused("reading the rules of can-gw", answers.error());
  answers->each([&rules](const nlmsghdr& message) { read_rule(message, rules); });
  return rules;
}

Result<void> KernelCanRules::send(const Result<Message>& message) {
  if (!message) return std::unexpected(message.error());
  if (const auto done = rtnl_.change(*message); !done) return refused("can-gw", done.error());
  return {};
}

Result<void> KernelCanRules::add(const CanRuleThere& rule) { return send(message_to_add(rule)); }

Result<void> KernelCanRules::remove(const CanRuleThere& rule) {
  return send(message_to_remove(rule));
}

}  // namespace mlcca::net
