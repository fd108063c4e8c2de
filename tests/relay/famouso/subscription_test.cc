// SPDX-License-Identifier: BSD-2-Clause
// Messages about subscriptions, to the byte.
#include "relay/famouso/subscription.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "mlcca/der_encode.hpp"
#include "tests/relay/bytes.hpp"

namespace mlcca::relay {
namespace {

using Kind = Subscription::Kind;

constexpr std::uint64_t kDistance = 0x44697374616e6365;  // "Distance"

const std::string kOwn = "5355425343524942";

TEST(SubscriptionTest, ANodeOfFamousoSendsTheSubjectAlone) {
  const Subscription plain{.subject = kDistance};
  EXPECT_EQ(encode(plain), bytes("44697374616e6365"));
  EXPECT_EQ(parse_subscription(bytes("44697374616e6365")), plain);
  // Its gateways read the first octets of what is longer, and so do we.
  EXPECT_EQ(parse_subscription(bytes("44697374616e636500ff")), plain);
}

TEST(SubscriptionTest, TheRequirementIsWhatACompileTimeSpecificationGives) {
  Subscription subscribe{.kind = Kind::subscribe,
                         .subject = kDistance,
                         .number = 0x01020304,
                         .lease_s = 60,
                         .hops = 8};
  subscribe.required.set(Attribute::latency, 10'000'000).set(Attribute::omission, 2);
  std::vector<std::uint8_t> expected = bytes(kOwn +
                                             "01"
                                             "01"
                                             "01020304"
                                             "003c"
                                             "08");
  std::vector<std::uint8_t> blob(der::kMaxPlainSize);
  blob.resize(der::encode(der::Channel(der::Role::subscriber, kDistance, subscribe.required),
                          blob.data(), blob.size()));
  expected.insert(expected.end(), blob.begin(), blob.end());
  EXPECT_EQ(encode(subscribe), expected);
  EXPECT_EQ(parse_subscription(expected), subscribe);
}

TEST(SubscriptionTest, TheExampleOfTheReferenceIsOne) {
  Subscription subscribe{
      .kind = Kind::subscribe, .subject = kDistance, .number = 7, .lease_s = 60, .hops = 8};
  subscribe.required.set(Attribute::latency, 10'000'000);
  EXPECT_EQ(encode(subscribe),
            bytes(kOwn + "0101"
                         "00000007"
                         "003c"
                         "08"
                         "30180201010a0101040844697374616e63653006810400989680"));
}

TEST(SubscriptionTest, AnswersAndTheEndNameTheSubscription) {
  const Subscription end{.kind = Kind::end, .subject = kDistance, .number = 7};
  EXPECT_EQ(encode(end), bytes(kOwn + "0102"
                                      "00000007"
                                      "0000"
                                      "00"
                                      "44697374616e6365"));
  EXPECT_EQ(parse_subscription(encode(end)), end);
  const Subscription granted{.kind = Kind::granted, .subject = kDistance, .number = 7};
  EXPECT_EQ(parse_subscription(encode(granted)), granted);
  Subscription refused{.kind = Kind::refused, .subject = kDistance, .number = 7};
  refused.reason = "bus: 12 ms of 10 ms";
  EXPECT_EQ(parse_subscription(encode(refused)), refused);
}

TEST(SubscriptionTest, AReasonIsCutOffAndPrintable) {
  Subscription refused{.kind = Kind::refused, .subject = kDistance};
  refused.reason = std::string(kLongestReason + 50, 'x');
  const auto cut = encode(refused);
  EXPECT_EQ(cut.size(), 17 + 8 + kLongestReason);
  EXPECT_LE(cut.size(), 256U);
  EXPECT_EQ(parse_subscription(cut)->reason.size(), kLongestReason);
  auto longer = cut;
  longer.push_back('x');
  EXPECT_FALSE(parse_subscription(longer));
  auto dirty = cut;
  dirty.back() = '\n';
  EXPECT_EQ(parse_subscription(dirty)->reason.back(), '?');
}

TEST(SubscriptionTest, WhatIsNoMessageIsNone) {
  const std::string head = kOwn +
                           "0102"
                           "00000007"
                           "0000"
                           "00";
  for (const std::string& hex :
       {std::string(), std::string("44697374616e63"), std::string("0000000000000000"), kOwn,
        kOwn + "0102000000070000", head, head + "44697374616e63", head + "0000000000000000",
        head + "44697374616e636500",  // more behind it
        kOwn + "0202"
               "00000007"
               "0000"
               "00"
               "44697374616e6365",  // version
        kOwn + "0105"
               "00000007"
               "0000"
               "00"
               "44697374616e6365",  // kind
        kOwn + "0100"
               "00000007"
               "0000"
               "00"
               "44697374616e6365",
        kOwn + "0101"
               "00000007"
               "003c"
               "08"
               "44697374616e6365",  // no blob
        kOwn + "0101"
               "00000007"
               "003c"
               "08"})
    EXPECT_FALSE(parse_subscription(bytes(hex))) << hex;
  // A publisher's specification is no subscriber's.
  auto wrong = bytes(kOwn +
                     "0101"
                     "00000007"
                     "003c"
                     "08");
  std::vector<std::uint8_t> blob(der::kMaxPlainSize);
  blob.resize(der::encode(der::Channel(der::Role::publisher, kDistance, AttributeSet{}),
                          blob.data(), blob.size()));
  wrong.insert(wrong.end(), blob.begin(), blob.end());
  EXPECT_FALSE(parse_subscription(wrong));
}

}  // namespace
}  // namespace mlcca::relay
