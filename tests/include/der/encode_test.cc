// SPDX-License-Identifier: BSD-2-Clause
// The writer: octets as X.690 has them, and what has no encoding.
#include <gtest/gtest.h>

#include "mlcca/der_encode.hpp"
#include "tests/include/der/octets.hpp"
#include "tests/include/der/random_channel.hpp"

namespace mlcca::testing {
namespace {

using der::Channel;
using der::Error;
using der::Role;
using der::UserAttribute;

Octets encode(const Channel& channel) {
  Octets octets(der::kMaxSize);
  octets.resize(der::encode(channel, octets.data(), octets.size()));
  return octets;
}
Channel subscriber(const AttributeSet& attributes) { return {Role::subscriber, 0x17, attributes}; }

TEST(EncodeTest, IntegersHaveTheirShortestForm) {
  const std::pair<Value, Octets> rows[] = {
      {0, {0x81, 1, 0}},
      {1, {0x81, 1, 1}},
      {127, {0x81, 1, 0x7f}},
      {128, {0x81, 2, 0, 0x80}},
      {255, {0x81, 2, 0, 0xff}},
      {256, {0x81, 2, 1, 0}},
      {32767, {0x81, 2, 0x7f, 0xff}},
      {32768, {0x81, 3, 0, 0x80, 0}},
      {Value{1} << 63, {0x81, 9, 0, 0x80, 0, 0, 0, 0, 0, 0, 0}},
      {kUnbounded, {0x81, 9, 0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff}},
  };
  for (const auto& [value, octets] : rows)
    EXPECT_EQ(encode(subscriber(AttributeSet().set(Attribute::latency, value))),
              encoding(kSubscriberHead, octets))
        << value;
}

TEST(EncodeTest, MarksEndWithTheLastThatIsSet) {
  const AttributeSet set = AttributeSet().set(Attribute::jitter, 1, true).set(Attribute::period, 2);
  EXPECT_EQ(encode({Role::network, 0, set}),
            encoding(kNetworkHead, {0x80, 2, 6, 0x40, 0x82, 1, 1, 0x84, 1, 2}));
}

TEST(EncodeTest, LengthsGrowWithTheContents) {
  const std::string name(63, 'n');
  const UserAttribute one[] = {{name.data(), name.size(), 1}};
  const Channel long_form(Role::subscriber, 0x17, {}, one, 1);
  EXPECT_EQ(encode(long_form),
            encoding(kSubscriberHead, {}, element(0x30, user(name, {0x02, 1, 1}))));
  UserAttribute many[4];
  const std::string names[] = {std::string(63, 'a'), std::string(63, 'b'), std::string(63, 'c'),
                               std::string(63, 'd')};
  Octets users;
  for (std::size_t i = 0; i < 4; ++i) {
    many[i] = {names[i].data(), names[i].size(), i};
    users = join({users, user(names[i], {0x02, 1, static_cast<std::uint8_t>(i)})});
  }
  EXPECT_EQ(encode({Role::subscriber, 0x17, {}, many, 4}),
            encoding(kSubscriberHead, {}, element(0x30, users)));
}

TEST(EncodeTest, WhatHasNoEncodingIsRefused) {
  const UserAttribute same[] = {{"a", 1}, {"a", 2}};
  const UserAttribute unsorted[] = {{"b", 1}, {"a", 2}};
  const UserAttribute marked[] = {{"a", 1, true}};
  const UserAttribute unnamed[] = {{"", 1}};
  const UserAttribute not_utf8[] = {{"\xff", 1}};
  const UserAttribute cut_off[] = {{"\u20ac", 2, 1}};  // the third octet is not part of the name
  UserAttribute many[der::kMaxUserAttributes + 1];
  const AttributeSet dynamic = AttributeSet().set(Attribute::latency, 1, true);
  const std::pair<Channel, Error> rows[] = {
      {{Role::subscriber, 0, {}}, Error::subject},
      {{Role::publisher, 1, dynamic}, Error::marks},
      {{Role::subscriber, 1, {}, same, 2}, Error::order},
      {{Role::subscriber, 1, {}, unsorted, 2}, Error::order},
      {{Role::subscriber, 1, {}, marked, 1}, Error::marks},
      {{Role::subscriber, 1, {}, unnamed, 1}, Error::name},
      {{Role::subscriber, 1, {}, not_utf8, 1}, Error::name},
      {{Role::subscriber, 1, {}, cut_off, 1}, Error::name},
      {{Role::subscriber, 1, {}, many, der::kMaxUserAttributes + 1}, Error::user_attributes},
      // NOLINTNEXTLINE(clang-analyzer-optin.core.EnumCastOutOfRange)
      {{static_cast<Role>(3), 1, {}}, Error::role},
  };
  for (const auto& [channel, error] : rows) {
    EXPECT_EQ(der::encodable(channel), error) << der::to_text(error);
    EXPECT_TRUE(encode(channel).empty());
  }
  EXPECT_EQ(der::encodable({Role::network, 0, dynamic, marked, 1}), Error::none);
}

TEST(EncodeTest, BufferThatIsTooSmallIsNotTouched) {
  const Channel channel = subscriber(AttributeSet().set(Attribute::omission, 2));
  Octets octets(der::encoded_size(channel), 0xaa);
  EXPECT_EQ(der::encode(channel, octets.data(), octets.size() - 1), 0U);
  EXPECT_EQ(octets, Octets(octets.size(), 0xaa));
  EXPECT_EQ(der::encode(channel, octets.data(), octets.size()), octets.size());
}

TEST(EncodeTest, RandomChannelsComeBackAsTheyWere) {
  RandomWorld world(3);
  for (int round = 0; round < 20000; ++round) {
    const RandomChannel random(world);
    const Channel& channel = random.get();
    const Octets octets = random.encoded();
    der::Decoded decoded;
    ASSERT_TRUE(der::decode(octets.data(), octets.size(), &decoded).ok());
    ASSERT_EQ(decoded.role, channel.role);
    ASSERT_EQ(decoded.subject, channel.subject);
    ASSERT_EQ(decoded.attributes, channel.attributes);
    std::size_t i = 0;
    for (const UserAttribute& user : decoded.user) {
      ASSERT_LT(i, channel.users);
      ASSERT_EQ(std::string_view(user.name, user.name_size),
                std::string_view(channel.user[i].name, channel.user[i].name_size));
      ASSERT_EQ(user.value, channel.user[i].value);
      ASSERT_EQ(user.dynamic, channel.user[i].dynamic);
      ++i;
    }
    ASSERT_EQ(i, channel.users);
  }
}

}  // namespace
}  // namespace mlcca::testing
