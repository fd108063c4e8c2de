// SPDX-License-Identifier: BSD-2-Clause
// Numbers of nodes and tags of subjects, as FAMOUSO's own programs deal them and ask for them.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "relay/famouso/node_numbers.hpp"
#include "relay/famouso/tag_broker.hpp"
#include "tests/relay/famouso/node_client.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;

Uid uid_of(const std::string& text) {
  Uid out{};
  std::copy_n(text.begin(), std::min(text.size(), out.size()), out.begin());
  return out;
}

/// "1F5FC000#6E65": as candump and the reference write frames.
Frame frame(const std::string& text) {
  Frame out;
  out.id = static_cast<std::uint32_t>(std::stoul(text.substr(0, 8), nullptr, 16));
  for (std::size_t i = 9; i + 1 < text.size(); i += 2)
    out.data[out.length++] = static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16));
  return out;
}
std::string text_of(const std::optional<Frame>& frame) {
  if (!frame) return "";
  static constexpr const char* kDigits = "0123456789ABCDEF";
  std::string out;
  for (int shift = 28; shift >= 0; shift -= 4)
    out += kDigits[frame->id >> static_cast<unsigned>(shift) & 15U];
  out += '#';
  for (std::size_t i = 0; i < frame->length; ++i) {
    out += kDigits[frame->data[i] >> 4U];
    out += kDigits[frame->data[i] & 15U];
  }
  return out;
}

// --- nodes ---------------------------------------------------------------------------------------

/// What a node of FAMOUSO sends, and what its broker answers.
const std::vector<std::pair<std::string, std::string>> kRun = {
    {"1F7D8001#", "1F7FC000#600000000000000F"}, {"1F7B8001#", "1F7FC000#6E0000000000000E"},
    {"1F758001#", "1F7FC000#6E6000000000000D"}, {"1F73C001#", "1F7FC000#6E6F00000000000C"},
    {"1F6D8001#", "1F7FC000#6E6F60000000000B"}, {"1F690001#", "1F7FC000#6E6F64000000000A"},
    {"1F658001#", "1F7FC000#6E6F646000000009"}, {"1F614001#", "1F7FC000#6E6F646500000008"},
    {"1F5CC001#", "1F5FC000#6E6F646530000007"}, {"1F580001#", "1F5FC000#6E6F646530000006"},
    {"1F54C001#", "1F5FC000#6E6F646530300005"}, {"1F500001#", "1F5FC000#6E6F646530300004"},
    {"1F4CC001#", "1F5FC000#6E6F646530303003"}, {"1F480001#", "1F5FC000#6E6F646530303002"},
    {"1F44C001#", "1F5FC000#6E6F646530303031"}, {"1F404001#", "1F5F4000#6E6F646530303031"}};

TEST(NodeBroker, AnswersEachStageAsFamouso) {
  NodeBroker broker(uid_of("Schulze"));
  for (const auto& [request, answer] : kRun)
    EXPECT_EQ(text_of(broker.take(frame(request), 0)), answer) << request;
  EXPECT_EQ(broker.number_of(uid_of("Schulze")), 0x7e);
  EXPECT_EQ(broker.number_of(uid_of("node0001")), 0x7d);
  EXPECT_FALSE(broker.due());
}

TEST(NodeClient, AsksAsANodeOfFamouso) {
  NodeClient node(uid_of("node0001"));
  std::string sent = text_of(node.start(0));
  for (const auto& [request, answer] : kRun) {
    EXPECT_EQ(sent, request);
    sent = text_of(node.take(frame(answer), 0));
  }
  EXPECT_EQ(sent, "");
  EXPECT_EQ(node.number(), 0x7d);
}

/// Both at once, over what may get lost: until the node has its number, at most a minute.
std::optional<NodeNumber> agree(NodeBroker& broker, NodeClient& node, std::set<int> lost,
                                std::uint64_t& now) {
  int sent = 0;
  std::optional<Frame> to_broker = node.start(now);
  for (const std::uint64_t end = now + 60 * kSecond; !node.number() && now < end;) {
    std::optional<Frame> to_node;
    if (to_broker && !lost.contains(sent++)) to_node = broker.take(*to_broker, now);
    to_broker.reset();
    if (!to_node && broker.due()) {
      now = std::max(now, std::min(*broker.due(), node.due()));
      to_node = broker.expire(now);
    }
    if (to_node && !lost.contains(sent++)) to_broker = node.take(*to_node, now);
    if (!to_broker && !node.number()) {
      now = std::max(now, std::min(node.due(), broker.due().value_or(node.due())));
      to_broker = node.expire(now);
    }
  }
  return node.number();
}

TEST(NodeProtocol, WhateverFrameIsLostTheNodeHasItsNumberAndTheBrokerServesTheNextOne) {
  for (int first = 0; first < 32; ++first)
    for (int second = first; second < 34; second += 5) {
      NodeBroker broker(uid_of("Schulze"));
      std::uint64_t now = 0;
      NodeClient node(uid_of("node0001"));
      EXPECT_EQ(agree(broker, node, {first, second}, now), 0x7d) << first << ' ' << second;
      NodeClient next(uid_of("another"));
      EXPECT_EQ(agree(broker, next, {}, now), 0x7c) << first << ' ' << second;
    }
}

TEST(NodeBroker, ANodeThatDiesInTheMiddleIsGivenUpAndThatIsSaid) {
  NodeBroker broker(uid_of("Schulze"));
  broker.take(frame(kRun[0].first), 0);
  broker.take(frame(kRun[1].first), 5);
  EXPECT_EQ(broker.due(), kSecond + 5);
  EXPECT_EQ(text_of(broker.expire(kSecond + 4)), "");
  EXPECT_EQ(text_of(broker.expire(kSecond + 5)), "1F5FC000#0000000000000000");
  EXPECT_FALSE(broker.due());
  for (const auto& [request, answer] : kRun)
    EXPECT_EQ(text_of(broker.take(frame(request), 2 * kSecond)), answer);
}

TEST(NodeClient, GivesWayToANodeWhoseBitsTheBrokerHasTaken) {
  NodeClient node(uid_of("node0001"));
  node.start(0);
  EXPECT_EQ(text_of(node.take(frame("1F7FC000#500000000000000F"), 0)), "") << "another's nibble";
  EXPECT_EQ(text_of(node.take(frame("1F7FC000#600000000000000F"), 0)), "") << "it stays silent";
  EXPECT_EQ(text_of(node.take(frame("1F5F4000#5E6F646530303031"), 0)), "1F7D8001#")
      << "and begins again after the other one's answer";
}

TEST(NodeClient, AsksAgainLessAndLessOften) {
  NodeClient node(uid_of("node0001"));
  node.start(0);
  std::uint64_t now = 0;
  std::vector<std::uint64_t> waits;
  for (int i = 0; i < 8; ++i) {
    EXPECT_FALSE(node.expire(node.due() - 1));
    waits.push_back(node.due() - now);
    now = node.due();
    EXPECT_EQ(text_of(node.expire(now)), "1F7D8001#");
  }
  EXPECT_EQ(waits.front(), kSecond / 4);
  EXPECT_EQ(waits.back(), 8 * kSecond);
}

TEST(NodeBroker, ANumberStaysItsNodesOverRestartsAndNoneIsDealtTwice) {
  std::vector<NodeBroker::Dealt> kept;
  {
    NodeBroker broker(uid_of("broker"));
    for (const auto& [request, answer] : kRun) broker.take(frame(request), 0);
    kept.assign(broker.dealt().begin(), broker.dealt().end());
  }
  NodeBroker broker(uid_of("other"), kept);
  EXPECT_EQ(broker.number_of(uid_of("node0001")), 0x7d);
  EXPECT_EQ(broker.number_of(uid_of("other")), 0x7c);
  std::uint64_t now = 0;
  std::set<NodeNumber> numbers{0x7e, 0x7d, 0x7c};
  for (int i = 0; i < 124; ++i) {
    NodeClient node(uid_of("n" + std::to_string(i)));
    const auto number = agree(broker, node, {}, now);
    ASSERT_TRUE(number) << i;
    EXPECT_TRUE(numbers.insert(*number).second);
  }
  EXPECT_EQ(numbers.size(), 127U);
  NodeClient last(uid_of("too many"));
  EXPECT_FALSE(agree(broker, last, {}, now));
  NodeClient known(uid_of("n5"));
  EXPECT_TRUE(agree(broker, known, {}, now)) << "who has a number gets it although all are dealt";
}

TEST(NodeBroker, AUidOfZerosHasNoNumber) {
  NodeBroker broker(uid_of("broker"));
  std::optional<Frame> answer;
  for (unsigned stage = 16; stage-- > 0;)
    answer = broker.take({.id = 0x1f400001U | stage << 18U, .length = 0, .data = {}}, 0);
  EXPECT_FALSE(answer);
  EXPECT_EQ(broker.dealt().size(), 1U);
}

TEST(NodeBroker, WhatIsNoRequestIsIgnored) {
  NodeBroker broker(uid_of("broker"));
  for (const char* other : {"1F5F7FFE#68656C6C6F", "1F5F4002#44697374616E6365", "007D8001#",
                            "1F798001#"})  // of stage 14
    EXPECT_FALSE(broker.take(frame(other), 0)) << other;
  EXPECT_FALSE(broker.due());
}

// --- tags ----------------------------------------------------------------------------------------

std::vector<std::string> answers(TagBroker& broker, const std::string& request) {
  const auto answer = broker.take(frame(request));
  if (!answer) return {};
  return {text_of((*answer)[0]), text_of((*answer)[1])};
}

TEST(TagBroker, DealsAsFamouso) {
  TagBroker broker;
  using Two = std::vector<std::string>;
  EXPECT_EQ(answers(broker, "1F5F4002#5355425343524942"),
            (Two{"1F5FC004#7D003FFF53554253", "1F5FC004#7D013FFF43524942"}));
  EXPECT_EQ(answers(broker, "1F5F4002#44697374616E6365"),
            (Two{"1F5FC004#7D003FFE44697374", "1F5FC004#7D013FFE616E6365"}));
  EXPECT_EQ(answers(broker, "1F400002#5355425343524942"),
            (Two{"1F5FC004#00003FFF53554253", "1F5FC004#00013FFF43524942"}))
      << "the same for every node";
}

TEST(TagBroker, KeepsWhatWasDealtAndDealsNothingTwice) {
  const std::vector<TagBroker::Dealt> before = {{7, 0x3ffe}, {8, 0x64},   {9, 0x3ffe},
                                                {7, 0x200},  {0, 0x3ffd}, {10, 0x4000}};
  TagBroker broker(before);
  EXPECT_EQ(broker.dealt().size(), 2U)
      << "a tag or a subject for the second time counts for nothing";
  EXPECT_EQ(broker.tag_of_subject(7), 0x3ffe);
  EXPECT_EQ(broker.tag_of_subject(8), 0x64);
  EXPECT_EQ(broker.tag_of_subject(1), 0x3fff);
  EXPECT_EQ(broker.tag_of_subject(2), 0x3ffd);
}

TEST(TagBroker, WithoutATagLeftThereIsNoAnswer) {
  TagBroker broker;
  std::set<TagNumber> tags;
  for (SubjectId subject = 1; subject <= 0x3fff - 0x64 + 1; ++subject)
    tags.insert(broker.tag_of_subject(subject).value());
  EXPECT_EQ(*tags.begin(), 0x64);
  EXPECT_EQ(tags.size(), 0x3fffU - 0x64 + 1);
  EXPECT_FALSE(broker.tag_of_subject(0xffff'ffff));
  EXPECT_TRUE(answers(broker, "1F5F4002#44697374616E6365").empty());
  EXPECT_TRUE(broker.tag_of_subject(5));
}

TEST(TagBroker, WhatIsNoRequestIsIgnored) {
  TagBroker broker;
  for (const char* other :
       {"1F5F4002#446973", "1F7F4002#44697374616E6365", "1F5F4003#44697374616E6365",
        "005F4002#44697374616E6365", "1F5F4002#0000000000000000"})
    EXPECT_TRUE(answers(broker, other).empty()) << other;
  EXPECT_TRUE(broker.dealt().empty());
}

}  // namespace
}  // namespace mlcca::relay
