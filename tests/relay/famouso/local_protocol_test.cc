// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/local_protocol.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace mlcca::relay {
namespace {

using Stream = std::vector<std::uint8_t>;
using Role = LocalSession::Role;

constexpr std::uint64_t kDistance = 0x44697374616e6365;

Stream from_hex(std::string text) {
  std::erase(text, ' ');
  Stream out;
  for (std::size_t i = 0; i < text.size(); i += 2)
    out.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  return out;
}
std::string text_of(const Stream& octets) { return {octets.begin(), octets.end()}; }

class LocalProtocol : public ::testing::Test {
 protected:
  void take(const Stream& octets) { session_.take(octets, events_); }
  void take(const std::string& hex) { take(from_hex(hex)); }

  LocalSession session_;
  std::vector<LocalSession::Event> events_;
};

TEST_F(LocalProtocol, AnEventGoesFromAPublisherToASubscriberAsInFamouso) {
  LocalSession subscriber;
  subscriber.take(from_hex("50 44 69 73 74 61 6E 63 65"), events_);
  EXPECT_EQ(subscriber.role(), Role::subscriber);
  EXPECT_EQ(subscriber.subject(), kDistance);
  take("56 44 69 73 74 61 6E 63 65");
  EXPECT_EQ(session_.role(), Role::publisher);
  take("52 44 69 73 74 61 6E 63 65 00 00 00 03 61 62 63");
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(text_of(events_[0]), "abc");
  EXPECT_TRUE(subscriber.send(events_[0]));
  EXPECT_TRUE(std::ranges::equal(subscriber.waiting(),
                                 from_hex("52 44 69 73 74 61 6E 63 65 00 00 00 03 61 62 63")));
}

TEST_F(LocalProtocol, AnEventMayBeEmpty) {
  take("56 44 69 73 74 61 6E 63 65 52 44 69 73 74 61 6E 63 65 00 00 00 00");
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_TRUE(events_[0].empty());
}

/// FAMOUSO's handler sends it as an event of the announced channel.
TEST_F(LocalProtocol, AnEventOfAnotherSubjectEndsTheChannelAndGoesNowhere) {
  take("56 44 69 73 74 61 6E 63 65 52 44 69 73 74 61 6E 63 65 00 00 00 01 61");
  take("52 44 69 73 74 61 6E 63 66 00 00 00 01 62 52 44 69 73 74 61 6E 63 65 00 00 00 01 63");
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(text_of(events_[0]), "a");
  EXPECT_EQ(session_.role(), Role::ended);
  EXPECT_EQ(session_.why(), "an event of 0x44697374616e6366: 0x44697374616e6365 is announced");
  EXPECT_EQ(session_.kept(), 0U);
}

TEST_F(LocalProtocol, MessagesComeInAnyPieces) {
  Stream stream = from_hex("56 44 69 73 74 61 6E 63 65");
  for (std::uint8_t i = 0; i < 20; ++i) {
    const Stream head = from_hex("52 44 69 73 74 61 6E 63 65 00 00 00");
    stream.insert(stream.end(), head.begin(), head.end());
    stream.push_back(i);
    stream.insert(stream.end(), i, i);
  }
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    LocalSession session;
    std::vector<LocalSession::Event> events;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t piece = std::min<std::size_t>(1 + random() % 40, stream.size() - at);
      session.take(std::span(stream).subspan(at, piece), events);
      at += piece;
    }
    ASSERT_EQ(events.size(), 20U);
    for (std::uint8_t i = 0; i < 20; ++i) ASSERT_EQ(events[i], Stream(i, i));
  }
}

TEST_F(LocalProtocol, WhatIsNoMessageEndsTheChannel) {
  take("51 44 69 73 74 61 6E 63 65");
  EXPECT_EQ(session_.role(), Role::ended);
  EXPECT_EQ(session_.why(), "the first octet is neither 0x50 (subscribe) nor 0x56 (announce)");
  LocalSession publisher;
  publisher.take(from_hex("56 44 69 73 74 61 6E 63 65 56"), events_);
  EXPECT_EQ(publisher.role(), Role::ended);
  LocalSession subscriber;
  subscriber.take(from_hex("50 44 69 73 74 61 6E 63 65"), events_);
  EXPECT_EQ(subscriber.role(), Role::subscriber);
  subscriber.take(from_hex("51"), events_);
  EXPECT_EQ(subscriber.role(), Role::ended);
  EXPECT_TRUE(events_.empty());
}

TEST_F(LocalProtocol, TheLongestEventHas65535Octets) {
  take("56 44 69 73 74 61 6E 63 65 52 44 69 73 74 61 6E 63 65 00 00 FF FF");
  take(Stream(65'534, 1));
  EXPECT_TRUE(events_.empty());
  take(Stream(1, 2));
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].size(), 65'535U);
  EXPECT_EQ(session_.kept(), 0U);
  take("52 44 69 73 74 61 6E 63 65 00 01 00 00");
  EXPECT_EQ(session_.role(), Role::ended);
  EXPECT_EQ(session_.why(), "an event of 65536 octets: at most 65535 are possible");
}

TEST_F(LocalProtocol, ASubscriberThatDoesNotReadLosesEventsAndNotTheirOrder) {
  take("50 44 69 73 74 61 6E 63 65");
  std::size_t sent = 0;
  while (session_.send(Stream(987, static_cast<std::uint8_t>(sent)))) ++sent;
  EXPECT_EQ(sent, 100U);
  EXPECT_EQ(session_.lost(), 1U);
  EXPECT_EQ(session_.waiting().size(), 100'000U);
  session_.written(1'500);
  EXPECT_EQ(session_.waiting().size(), 98'500U);
  EXPECT_TRUE(session_.send(Stream(987, 77)));
  EXPECT_FALSE(session_.send(Stream(987, 78)));
  session_.written(session_.waiting().size());
  EXPECT_TRUE(session_.waiting().empty());
  EXPECT_FALSE(session_.send(Stream(65'536, 0)));
}

TEST_F(LocalProtocol, OnlyASubscriberIsSentEvents) {
  EXPECT_FALSE(session_.send(Stream(1, 1)));
  take("56 44 69 73 74 61 6E 63 65");
  EXPECT_FALSE(session_.send(Stream(1, 1)));
  EXPECT_TRUE(session_.waiting().empty());
}

TEST_F(LocalProtocol, NoMoreThanOneMessageIsKept) {
  take("56 44 69 73 74 61 6E 63 65 52 44 69 73 74 61 6E 63 65 00 00 FF FF");
  take(Stream(200'000, 0x52));
  EXPECT_EQ(events_.size(), 1U) << "what follows it is an event of 0x52525252 octets";
  EXPECT_EQ(session_.role(), Role::ended);
  EXPECT_EQ(session_.kept(), 0U);
}

}  // namespace
}  // namespace mlcca::relay
