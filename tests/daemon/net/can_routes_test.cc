// SPDX-License-Identifier: BSD-2-Clause
// Messages to and from can-gw, octet by octet where the kernel reads them.
#include "daemon/net/can_routes.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/gw.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>

#include <cstring>

namespace mlcca::net {
namespace {

constexpr CanRule kPlain{.from = 7, .to = 8, .id = 0x9f480064, .mask = 0xdfffffff};
constexpr CanRule kTranslated{.from = 3,
                              .to = 4,
                              .id = 0x100,
                              .mask = 0xdfffffff,
                              .fd = true,
                              .keep = 0x20000000,
                              .set = 0x101};

std::vector<CanRuleThere> read(const nlmsghdr& message) {
  std::vector<CanRuleThere> rules;
  read_rule(message, rules);
  return rules;
}

nlattr* attribute(nlmsghdr* message, int type) {
  return nlmsg_find_attr(message, sizeof(rtcanmsg), type);
}

TEST(CanRoutesTest, AMessageIsWhatTheKernelExpects) {
  const auto message = message_to_add(ours(kPlain, kFirstUid));
  ASSERT_TRUE(message) << message.error().text;
  nlmsghdr* const header = nlmsg_hdr(message->get());
  EXPECT_EQ(header->nlmsg_type, RTM_NEWROUTE);
  EXPECT_EQ(header->nlmsg_flags, NLM_F_REQUEST | NLM_F_ACK);
  rtcanmsg head{};
  std::memcpy(&head, nlmsg_data(header), sizeof head);
  EXPECT_EQ(head.can_family, AF_CAN);
  EXPECT_EQ(head.gwtype, CGW_TYPE_CAN_CAN);
  EXPECT_EQ(head.flags, CGW_FLAGS_CAN_IIF_TX_OK);
  ASSERT_NE(attribute(header, CGW_MOD_OR), nullptr);
  EXPECT_EQ(nla_len(attribute(header, CGW_MOD_OR)), 17);
  EXPECT_EQ(attribute(header, CGW_MOD_AND), nullptr);
  ASSERT_NE(attribute(header, CGW_FILTER), nullptr);
  EXPECT_EQ(nla_len(attribute(header, CGW_FILTER)), 8);
}

TEST(CanRoutesTest, FdRulesChangeFdFrames) {
  const auto message = message_to_add(ours(kTranslated, kLastUid));
  ASSERT_TRUE(message);
  nlmsghdr* const header = nlmsg_hdr(message->get());
  EXPECT_EQ(attribute(header, CGW_MOD_OR), nullptr);
  ASSERT_NE(attribute(header, CGW_FDMOD_AND), nullptr);
  EXPECT_EQ(nla_len(attribute(header, CGW_FDMOD_AND)), 73);
}

TEST(CanRoutesTest, WhatWasWrittenIsReadAgain) {
  for (const CanRule& rule : {kPlain, kTranslated}) {
    const auto message = message_to_add(ours(rule, kFirstUid + 5));
    ASSERT_TRUE(message);
    const auto read_again = read(*nlmsg_hdr(message->get()));
    ASSERT_EQ(read_again.size(), 1U);
    EXPECT_EQ(read_again[0], ours(rule, kFirstUid + 5));
    EXPECT_TRUE(read_again[0].is_ours());
  }
}

TEST(CanRoutesTest, ARemovalNamesAllThatTheRuleWasMadeWith) {
  const auto message = message_to_remove(ours(kTranslated, kFirstUid));
  ASSERT_TRUE(message);
  nlmsghdr* const header = nlmsg_hdr(message->get());
  EXPECT_EQ(header->nlmsg_type, RTM_DELROUTE);
  header->nlmsg_type = RTM_NEWROUTE;
  EXPECT_EQ(read(*header), (std::vector{ours(kTranslated, kFirstUid)}));
}

TEST(CanRoutesTest, NeverAsksToRemoveEverything) {
  CanRule nowhere = kPlain;
  nowhere.from = nowhere.to = 0;
  EXPECT_FALSE(message_to_remove(ours(nowhere, kFirstUid)));
  EXPECT_FALSE(message_to_add(ours(nowhere, kFirstUid)));
}

TEST(CanRoutesTest, NeverTouchesARuleOfAnotherProgram) {
  for (const std::uint32_t uid : {0U, kFirstUid - 1, kLastUid + 1})
    EXPECT_FALSE(message_to_remove(ours(kPlain, uid))) << uid;
}

/// A message of the kernel about a rule that cangw made.
Message foreign(unsigned char family) {
  Message message(nlmsg_alloc_simple(RTM_NEWROUTE, 0));
  nl_msg* const m = message.get();
  rtcanmsg head{family, CGW_TYPE_CAN_CAN, CGW_FLAGS_CAN_ECHO};
  nlmsg_append(m, &head, sizeof head, NLMSG_ALIGNTO);
  nla_put_u32(m, CGW_HANDLED, 12);
  nla_put_u32(m, CGW_DROPPED, 3);
  nla_put_u32(m, CGW_DELETED, 1);
  nla_put_u8(m, CGW_LIM_HOPS, 2);
  cgw_frame_mod change{};
  change.cf.can_id = 0x101;
  change.modtype = CGW_MOD_ID | CGW_MOD_DATA;
  nla_put(m, CGW_MOD_SET, sizeof change, &change);
  nla_put_u32(m, CGW_SRC_IF, 5);
  nla_put_u32(m, CGW_DST_IF, 6);
  return message;
}

TEST(CanRoutesTest, ReadsWhatOthersMade) {
  const auto rules = read(*nlmsg_hdr(foreign(AF_CAN).get()));
  ASSERT_EQ(rules.size(), 1U);
  EXPECT_FALSE(rules[0].is_ours());
  EXPECT_EQ(rules[0].rule, (CanRule{.from = 5, .to = 6}));
  EXPECT_TRUE(rules[0].changes_more);
  EXPECT_EQ(rules[0].hops, 2);
  EXPECT_EQ(rules[0].handled, 12U);
  EXPECT_EQ(rules[0].dropped, 3U);
  EXPECT_EQ(rules[0].deleted, 1U);
}

TEST(CanRoutesTest, PassesOverTheRoutesOfOtherFamilies) {
  EXPECT_TRUE(read(*nlmsg_hdr(foreign(AF_INET).get())).empty());
}

TEST(CanRoutesTest, PassesOverWhatIsCutShort) {
  const auto message = foreign(AF_CAN);
  nlmsghdr* const header = nlmsg_hdr(message.get());
  const auto whole = header->nlmsg_len;
  for (header->nlmsg_len = NLMSG_HDRLEN; header->nlmsg_len < whole; ++header->nlmsg_len)
    EXPECT_TRUE(read(*header).empty()) << header->nlmsg_len;
}

}  // namespace
}  // namespace mlcca::net
