// SPDX-License-Identifier: BSD-2-Clause
// The reader: what it understands, what it refuses and where, and that nothing but the one
// encoding of a value is understood at all.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "mlcca/der_decode.hpp"
#include "tests/include/der/octets.hpp"
#include "tests/include/der/random_channel.hpp"

namespace mlcca::testing {
namespace {

using der::Decoded;
using der::Error;
using der::Status;

/// Decodes from memory of exactly that size, so that the address sanitizer sees any over-read.
Status decode(const Octets& octets, Decoded* out) {
  const auto exact = std::make_unique<std::uint8_t[]>(octets.size());
  std::ranges::copy(octets, exact.get());
  const Status status = der::decode(exact.get(), octets.size(), out);
  if (status.ok()) out->user = {};  // pointed into the copy
  return status;
}

/// What a decoded channel encodes to.
Octets encode_again(const Decoded& decoded) {
  std::vector<der::UserAttribute> users;
  for (const der::UserAttribute& user : decoded.user) users.push_back(user);
  const der::Channel channel(decoded.role, decoded.subject, decoded.attributes, users.data(),
                             users.size());
  Octets octets(der::encoded_size(channel));
  octets.resize(der::encode(channel, octets.data(), octets.size()));
  return octets;
}

TEST(DecodeTest, EmergencySwitchIsUnderstood) {
  const Octets octets = encoding(kSubscriberHead, {0x84, 4, 0x02, 0xfa, 0xf0, 0x80, 0x87, 1, 2});
  Decoded decoded;
  ASSERT_TRUE(decode(octets, &decoded).ok());
  EXPECT_EQ(decoded.role, der::Role::subscriber);
  EXPECT_EQ(decoded.subject, 0x17U);
  EXPECT_EQ(decoded.attributes,
            AttributeSet().set(Attribute::period, 50000000).set(Attribute::omission, 2));
  EXPECT_TRUE(decoded.user.empty());
}

TEST(DecodeTest, EachTagIsTheAttributeOfTheTable) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto tag = static_cast<std::uint8_t>(0x80 + kAttributeTable[i].tag);
    Decoded decoded;
    ASSERT_TRUE(decode(encoding(kSubscriberHead, {tag, 1, 9}), &decoded).ok());
    EXPECT_EQ(decoded.attributes, AttributeSet().set(attribute_at(i), 9))
        << kAttributeTable[i].name;
  }
}

TEST(DecodeTest, MarksBelongToTheirAttributes) {
  Decoded decoded;
  // 10010001: Latency, Period, MaxPayload.
  const Octets all = {0x80, 2, 0, 0x91, 0x81, 1, 1, 0x82, 1, 2, 0x84, 1, 4, 0x88, 1, 8};
  ASSERT_TRUE(decode(encoding(kNetworkHead, all), &decoded).ok());
  EXPECT_EQ(decoded.attributes, AttributeSet()
                                    .set(Attribute::latency, 1, true)
                                    .set(Attribute::jitter, 2)
                                    .set(Attribute::period, 4, true)
                                    .set(Attribute::max_payload, 8, true));
}

TEST(DecodeTest, UserAttributesComeOneByOneFromTheEncoding) {
  const Octets users = element(0x30, join({user("Colour", {0x02, 2, 0, 0x80}),
                                           user("Temp\u00e9", {0x02, 1, 0}, {0x01, 1, 0xff})}));
  const Octets octets = encoding(kNetworkHead, {}, users);
  Decoded decoded;
  ASSERT_TRUE(der::decode(octets.data(), octets.size(), &decoded).ok());
  auto at = decoded.user.begin();
  EXPECT_EQ(std::string((*at).name, (*at).name_size), "Colour");
  EXPECT_EQ((*at).value, 128U);
  EXPECT_FALSE((*at).dynamic);
  ++at;
  EXPECT_EQ(std::string((*at).name, (*at).name_size), "Temp\u00e9");
  EXPECT_EQ((*at).value, 0U);
  EXPECT_TRUE((*at).dynamic);
  ++at;
  EXPECT_TRUE(at == decoded.user.end());
}

struct Malformed {
  const char* name;
  Octets octets;
  Error error;
  std::size_t offset;
};

class MalformedTest : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedTest, IsRefusedWhereItOffendsAndLeavesTheResultAlone) {
  Decoded decoded;
  decoded.subject = 0x1234;
  const Status status = decode(GetParam().octets, &decoded);
  EXPECT_EQ(status.error, GetParam().error) << der::to_text(status.error);
  EXPECT_EQ(status.offset, GetParam().offset);
  EXPECT_EQ(decoded.subject, 0x1234U);
}

const Octets kPeriod = {0x84, 1, 1};
/// Where the attributes start in an encoding of less than 128 octets, and what follows n of them.
constexpr std::size_t kFirst = 20;

Octets many_users(std::size_t n) {
  Octets users;
  for (std::size_t i = 0; i < n; ++i)
    users = join({users, user(std::string(1, static_cast<char>('A' + i)))});
  return element(0x30, users);
}
Octets with_users(const Octets& users) {
  return encoding(kSubscriberHead, {}, element(0x30, users));
}
constexpr std::size_t kUsers = 22;  // where they start after no attributes

INSTANTIATE_TEST_SUITE_P(
    Head, MalformedTest,
    ::testing::Values(
        Malformed{"Nothing", {}, Error::truncated, 0},
        Malformed{"OnlyATag", {0x30}, Error::truncated, 0},
        Malformed{"NotASequence", {0x31, 0}, Error::tag, 0},
        Malformed{"EmptySequence", {0x30, 0}, Error::truncated, 2},
        Malformed{"Indefinite", join({{0x30, 0x80}, kSubscriberHead, {0x30, 0, 0, 0}}),
                  Error::length, 0},
        Malformed{"LongFormOfAShortLength", join({{0x30, 0x81, 18}, kSubscriberHead, {0x30, 0}}),
                  Error::length, 0},
        Malformed{"TwoOctetsOfLengthForOne", join({{0x30, 0x82, 0, 200}, Octets(200)}),
                  Error::length, 0},
        Malformed{"ThreeOctetsOfLength", {0x30, 0x83, 0, 0, 1, 0}, Error::length, 0},
        Malformed{"LengthCutOff", {0x30, 0x82, 1}, Error::truncated, 0},
        Malformed{"Trailing", join({encoding(kSubscriberHead, {}), {0}}), Error::trailing, 20},
        Malformed{"Oversize", element(0x30, Octets(der::kMaxSize - 3)), Error::too_long,
                  der::kMaxSize},
        Malformed{"NextVersion", encoding(head(2, 1), {}), Error::version, 2},
        Malformed{"UnknownRole", encoding(head(1, 3), {}), Error::role, 2},
        Malformed{"SubjectZero", encoding(head(1, 0, 0), {}), Error::subject, 2},
        Malformed{"ShortSubject",
                  element(0x30, {2, 1, 1, 10, 1, 1, 4, 7, 0, 0, 0, 0, 0, 0, 1, 0x30, 0}),
                  Error::length, 2},
        Malformed{"RoleAsInteger",
                  element(0x30, {2, 1, 1, 2, 1, 1, 4, 8, 0, 0, 0, 0, 0, 0, 0, 1, 0x30, 0}),
                  Error::tag, 2},
        Malformed{"LongVersion",
                  element(0x30, {2, 2, 0, 1, 10, 1, 1, 4, 8, 0, 0, 0, 0, 0, 0, 0, 1, 0x30, 0}),
                  Error::tag, 2},
        Malformed{"NoAttributes", element(0x30, kSubscriberHead), Error::truncated, 18},
        Malformed{"AttributesAsSet", element(0x30, join({kSubscriberHead, {0x31, 0}})), Error::tag,
                  18}),
    [](const auto& row) { return row.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Attributes, MalformedTest,
    ::testing::Values(
        Malformed{"WrongOrder", encoding(kSubscriberHead, {0x87, 1, 2, 0x84, 1, 1}), Error::order,
                  kFirst + 3},
        Malformed{"Twice", encoding(kSubscriberHead, {0x84, 1, 1, 0x84, 1, 1}), Error::order,
                  kFirst + 3},
        Malformed{"UnknownAttribute", encoding(kSubscriberHead, {0x89, 1, 1}), Error::tag, kFirst},
        Malformed{"UniversalTag", encoding(kSubscriberHead, {0x02, 1, 1}), Error::tag, kFirst},
        Malformed{"ConstructedTag", encoding(kSubscriberHead, {0xa4, 1, 1}), Error::tag, kFirst},
        Malformed{"HighTagForm", encoding(kSubscriberHead, {0x9f, 4, 1, 1}), Error::tag, kFirst},
        Malformed{"ValueCutOff", encoding(kSubscriberHead, {0x84, 2, 1}), Error::truncated, kFirst},
        Malformed{"TagOnly", encoding(kSubscriberHead, {0x84}), Error::truncated, kFirst},
        Malformed{"NoOctets", encoding(kSubscriberHead, {0x84, 0}), Error::integer, kFirst + 2},
        Malformed{"Negative", encoding(kSubscriberHead, {0x84, 1, 0x80}), Error::integer,
                  kFirst + 2},
        Malformed{"LeadingZero", encoding(kSubscriberHead, {0x84, 2, 0, 0x7f}), Error::integer,
                  kFirst + 2},
        Malformed{"TwoZeros", encoding(kSubscriberHead, {0x84, 2, 0, 0}), Error::integer,
                  kFirst + 2},
        Malformed{"NineOctets", encoding(kSubscriberHead, {0x84, 9, 1, 0, 0, 0, 0, 0, 0, 0, 0}),
                  Error::integer, kFirst + 2},
        Malformed{"TwoToThe64",
                  encoding(kSubscriberHead, {0x84, 10, 0, 0x80, 0, 0, 0, 0, 0, 0, 0, 0}),
                  Error::integer, kFirst + 3},
        Malformed{"LongFormOfAShortValue", encoding(kSubscriberHead, {0x84, 0x81, 1, 1}),
                  Error::length, kFirst},
        Malformed{"MarksInARequirement",
                  encoding(kSubscriberHead, join({{0x80, 2, 4, 0x10}, kPeriod})), Error::marks,
                  kFirst},
        Malformed{"MarksOfWhatIsNotThere",
                  encoding(kNetworkHead, join({{0x80, 2, 5, 0x20}, kPeriod})), Error::marks,
                  kFirst + 7},
        Malformed{"NoMarks", encoding(kNetworkHead, join({{0x80, 2, 0, 0}, kPeriod})), Error::marks,
                  kFirst + 4},
        Malformed{"MarksWithTrailingZeros",
                  encoding(kNetworkHead, join({{0x80, 2, 3, 0x10}, kPeriod})), Error::marks,
                  kFirst + 4},
        Malformed{"MarksInUnusedBits", encoding(kNetworkHead, join({{0x80, 2, 5, 0x10}, kPeriod})),
                  Error::marks, kFirst + 4},
        Malformed{"EightUnusedBits", encoding(kNetworkHead, join({{0x80, 2, 8, 0x10}, kPeriod})),
                  Error::marks, kFirst + 4},
        Malformed{"LongMarks", encoding(kNetworkHead, join({{0x80, 3, 4, 0x10, 0x10}, kPeriod})),
                  Error::length, kFirst},
        Malformed{"MarksAfterAttributes",
                  encoding(kNetworkHead, join({kPeriod, {0x80, 2, 4, 0x10}})), Error::order,
                  kFirst + 3}),
    [](const auto& row) { return row.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Users, MalformedTest,
    ::testing::Values(
        Malformed{"None", with_users({}), Error::user_attributes, kUsers},
        Malformed{"Seventeen", encoding(kSubscriberHead, {}, many_users(17)),
                  Error::user_attributes, 24 + 16 * 8},
        Malformed{"Unsorted", with_users(join({user("b"), user("a")})), Error::order, kUsers + 8},
        Malformed{"SameName", with_users(join({user("a"), user("a")})), Error::order, kUsers + 8},
        Malformed{"PrefixLast", with_users(join({user("ab"), user("a")})), Error::order,
                  kUsers + 9},
        Malformed{"EmptyName", with_users(user("")), Error::name, kUsers + 4},
        Malformed{"SixtyFourOctets", with_users(user(std::string(64, 'x'))), Error::name,
                  kUsers + 4},
        Malformed{"ControlCharacter", with_users(user("a\n")), Error::name, kUsers + 4},
        Malformed{"Delete", with_users(user("\x7f")), Error::name, kUsers + 4},
        Malformed{"OverlongUtf8", with_users(user("\xc0\xaf")), Error::name, kUsers + 4},
        Malformed{"Surrogate", with_users(user("\xed\xa0\x80")), Error::name, kUsers + 4},
        Malformed{"AboveUnicode", with_users(user("\xf4\x90\x80\x80")), Error::name, kUsers + 4},
        Malformed{"Utf8CutOff", with_users(user("\xe2\x82")), Error::name, kUsers + 4},
        Malformed{"NoValue", with_users(user("a", {})), Error::truncated, kUsers + 5},
        Malformed{"LeadingZero", with_users(user("a", {0x02, 2, 0, 1})), Error::integer,
                  kUsers + 7},
        Malformed{"FalseIsTheDefault", with_users(user("a", {0x02, 1, 1}, {0x01, 1, 0})),
                  Error::marks, kUsers + 10},
        Malformed{"OtherTrue", with_users(user("a", {0x02, 1, 1}, {0x01, 1, 1})), Error::marks,
                  kUsers + 10},
        Malformed{"MarkInARequirement", with_users(user("a", {0x02, 1, 1}, {0x01, 1, 0xff})),
                  Error::marks, kUsers},
        Malformed{"MoreAfterTheMark", with_users(user("a", {0x02, 1, 1}, {0x01, 1, 0xff, 0x05, 0})),
                  Error::tag, kUsers + 11},
        Malformed{"MoreAfterTheValue", with_users(user("a", {0x02, 1, 1}, {0x05, 0})), Error::tag,
                  kUsers + 8},
        Malformed{"MoreAfterThem",
                  encoding(kSubscriberHead, {}, join({element(0x30, user("a")), {0x05, 0}})),
                  Error::tag, kUsers + 8},
        Malformed{"SomethingElse", encoding(kSubscriberHead, {}, {0x05, 0}), Error::tag, 20}),
    [](const auto& row) { return row.param.name; });

TEST(DecodeTest, LargestEncodingIsUnderstood) {
  const Octets integer = {0x02, 9, 0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
  Octets attributes = {0x80, 2, 0, 0xff};
  for (std::uint8_t tag = 0x81; tag <= 0x88; ++tag) {
    attributes = join({attributes, integer});
    attributes[attributes.size() - integer.size()] = tag;
  }
  Octets users;
  for (char c = 'A'; c < 'A' + 16; ++c)
    users = join({users, user(std::string(63, c), integer, {0x01, 1, 0xff})});
  const Octets octets = encoding(kNetworkHead, attributes, element(0x30, users));
  EXPECT_EQ(octets.size(), der::kMaxSize);
  Decoded decoded;
  EXPECT_TRUE(decode(octets, &decoded).ok());
  EXPECT_EQ(decoded.attributes[Attribute::max_payload], kUnbounded);
  EXPECT_EQ(encoding(kNetworkHead, attributes).size(), der::kMaxPlainSize);
}

TEST(DecodeTest, EveryTruncationIsRefused) {
  RandomWorld world(1);
  for (int round = 0; round < 200; ++round) {
    const RandomChannel channel(world);
    const Octets whole = channel.encoded();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      Decoded decoded;
      ASSERT_FALSE(
          decode(Octets(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), &decoded)
              .ok());
    }
  }
}

TEST(DecodeTest, WhateverIsUnderstoodEncodesToTheSameOctets) {
  RandomWorld world(2);
  std::size_t understood = 0;
  for (int round = 0; round < 25; ++round) {
    const RandomChannel channel(world);
    Octets octets = channel.encoded();
    for (std::size_t at = 0; at < octets.size(); ++at) {
      const std::uint8_t original = octets[at];
      for (unsigned change = 1; change < 256; ++change) {
        octets[at] = static_cast<std::uint8_t>(original ^ change);
        Decoded decoded;
        if (!der::decode(octets.data(), octets.size(), &decoded).ok()) continue;
        ++understood;
        ASSERT_EQ(encode_again(decoded), octets) << "octet " << at << " changed by " << change;
      }
      octets[at] = original;
    }
  }
  // Each octet of the subject alone can take nearly all values.
  EXPECT_GT(understood, 25U * 8 * 250);
}

TEST(DecodeTest, ErrorsHaveATextEach) {
  std::vector<std::string> texts;
  for (int error = 0; error <= static_cast<int>(Error::range); ++error)
    texts.emplace_back(der::to_text(static_cast<Error>(error)));
  std::ranges::sort(texts);
  EXPECT_EQ(std::ranges::adjacent_find(texts), texts.end());
  EXPECT_EQ(std::ranges::find(texts, "unknown error"), texts.end());
}

}  // namespace
}  // namespace mlcca::testing
