// SPDX-License-Identifier: BSD-2-Clause
// What can-gw carries from one bus to another without showing it to a socket.
#include "tools/learn/kernel_copies.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/gw.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn {
namespace {

using test::kMs;
using test::kSecond;
using test::Sent;

// Their indices in the kernel are 10, 11 and 12.
const std::vector<std::string> kListened = {"can0", "can1", "can2"};

std::string name_of(int index) {
  if (index == 19) return "can9";  // learn does not listen to it
  return index >= 10 && index <= 12 ? "can" + std::to_string(index - 10) : "";
}

net::CanRuleThere rule(int from, int to, std::uint32_t id = 0, std::uint32_t mask = 0) {
  net::CanRuleThere out;
  out.rule.from = from;
  out.rule.to = to;
  out.rule.id = id;
  out.rule.mask = mask;
  return out;
}

using Numbers = std::vector<std::uint32_t>;

struct Copied {
  explicit Copied(std::vector<net::CanRuleThere> rules) {
    for (const std::string& name : kListened) numbers.number_of(name);
    carried = KernelCopies(rules, kListened, numbers, name_of);
  }
  std::vector<std::uint32_t> of(const Sent& sent,
                                std::optional<std::uint32_t> origin = std::nullopt) const {
    std::vector<std::uint32_t> out;
    carried.copies_of(sent.frame(), origin, [&](const Frame& copy) {
      EXPECT_EQ(copy.ns, sent.ns);
      EXPECT_EQ(copy.id, sent.id);
      out.push_back(copy.interface);
    });
    return out;
  }
  Interfaces numbers;
  KernelCopies carried;
};

Sent frame(std::uint32_t interface, std::uint32_t id) { return {5, interface, id, {1, 2}}; }

TEST(KernelCopies, ARuleCarriesWhatItsFilterTakes) {
  const Copied copied({rule(10, 11, 0x100, CAN_SFF_MASK)});
  EXPECT_EQ(copied.of(frame(0, 0x100)), (Numbers{1}));
  EXPECT_EQ(copied.of(frame(0, 0x101)), Numbers{});
  EXPECT_EQ(copied.of(frame(1, 0x100)), Numbers{}) << "the other direction";
}

TEST(KernelCopies, AnInvertedFilterCarriesTheRest) {
  const Copied copied({rule(10, 11, 0x100 | CAN_INV_FILTER, CAN_SFF_MASK)});
  EXPECT_EQ(copied.of(frame(0, 0x100)), Numbers{});
  EXPECT_EQ(copied.of(frame(0, 0x101)), (Numbers{1}));
}

TEST(KernelCopies, ARuleForFdFramesCarriesNoOthers) {
  auto fd = rule(10, 11);
  fd.rule.fd = true;
  const Copied copied({fd});
  EXPECT_EQ(copied.of(frame(0, 0x100)), Numbers{});
  Sent sent = frame(0, 0x100);
  sent.fd = true;
  EXPECT_EQ(copied.of(sent), (Numbers{1}));
}

TEST(KernelCopies, TwoRulesForTheSameFramesMakeOneCopy) {
  const Copied copied({rule(10, 11), rule(10, 11, 0x100, CAN_SFF_MASK), rule(10, 12)});
  EXPECT_EQ(copied.of(frame(0, 0x100)), (Numbers{1, 2}));
}

TEST(KernelCopies, WhatSocketsSeeIsNotMadeAgain) {
  auto echo = rule(10, 11);
  echo.flags = CGW_FLAGS_CAN_ECHO;
  const Copied copied({echo, rule(11, 10), rule(11, 12)});
  EXPECT_EQ(copied.of(frame(0, 0x100)), Numbers{});
  EXPECT_EQ(copied.of(frame(1, 0x100)), (Numbers{0, 2})) << "of a station of can1";
  EXPECT_EQ(copied.of(frame(1, 0x100), 0), Numbers{}) << "can-gw carries a frame once";
}

TEST(KernelCopies, RulesThatADraftCannotHaveAreNamed) {
  auto changed = rule(10, 11);
  changed.changes_more = true;
  auto translated = rule(10, 12);
  translated.rule.keep = 0x7f;
  auto seen = translated;
  seen.flags = CGW_FLAGS_CAN_ECHO;
  const Copied copied({changed, translated, seen, rule(10, 19), rule(19, 10), rule(10, 13)});
  EXPECT_EQ(copied.of(frame(0, 0x100)), Numbers{});
  const std::vector<std::string> expected = {
      "of can0 to can1 and changes them",
      "of can0 to can2 and gives them other identifiers: state these",
      "of can0 to can2 and gives them other identifiers: the draft has one channel",
      "of can0 to can9 and learn does not listen there", "of can0 to an interface that is gone"};
  const auto& notes = copied.carried.notes();
  ASSERT_EQ(notes.size(), expected.size());
  for (std::size_t i = 0; i < notes.size(); ++i)
    EXPECT_NE(notes[i].find(expected[i]), std::string::npos) << notes[i];
}

TEST(KernelCopies, WhatTheyCarryCrossesInTheDraft) {
  const Copied copied({rule(10, 11, 0x100, CAN_SFF_MASK)});
  const auto sent = test::Traffic(7)
                        .periodic(0, 0x100, 100 * kMs, kMs, 8, 20)
                        .periodic(0, 0x101, 100 * kMs, kMs, 8, 20)
                        .periodic(1, 0x200, 50 * kMs, kMs, 4, 20)
                        .sent();
  std::vector<Sent> all;
  for (const Sent& one : sent) {
    all.push_back(one);
    copied.carried.copies_of(one.frame(), std::nullopt, [&](const Frame& copy) {
      all.push_back(one);
      all.back().interface = copy.interface;
    });
  }
  const Draft draft = test::drafted(all);
  for (const auto& channel : draft.channels)
    EXPECT_EQ(channel.crosses_to, channel.name == "can0-100" ? std::vector<std::string>{"can1"}
                                                             : std::vector<std::string>{})
        << channel.name;
  EXPECT_EQ(test::refused_in(draft), 0U);
}

TEST(KernelCopies, AnObserverSaysWhereAFrameWasBefore) {
  Observer observer;
  EXPECT_EQ(observer.add(frame(0, 0x100).frame()), std::nullopt);
  Sent copy = frame(1, 0x100);
  copy.ns += kMs;
  EXPECT_EQ(observer.add(copy.frame()), std::optional<std::uint32_t>(0));
  copy.ns += kSecond;
  EXPECT_EQ(observer.add(copy.frame()), std::nullopt);
}

}  // namespace
}  // namespace mlcca::learn
