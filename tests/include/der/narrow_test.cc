// SPDX-License-Identifier: BSD-2-Clause
// The narrow values against the wide ones: the same outcome where every value is a whole number of
// units, never a better one elsewhere.
#include "mlcca/narrow.hpp"

#include <gtest/gtest.h>

#include "mlcca/der_narrow.hpp"
#include "tests/include/der/octets.hpp"
#include "tests/include/der/random_channel.hpp"

namespace mlcca::testing {
namespace {

/// Units that nothing is a round number of.
struct OddUnits {
  using Value = std::uint16_t;
  static constexpr std::uint32_t kTime = 12345677;
  static constexpr std::uint32_t kRate = 7;
  static constexpr std::uint32_t kLoss = 300007;
  static constexpr std::uint32_t kEvents = 3;
  static constexpr std::uint32_t kSize = 0x7fffffff;
};

template <class Units>
Value unit_of(Attribute a) {
  const std::string unit = info(a).unit;
  if (unit == "ns") return Units::kTime;
  if (unit == "bytes/s") return Units::kRate;
  if (unit == "1e-9") return Units::kLoss;
  return unit == "events" ? Units::kEvents : Units::kSize;
}
template <class Units>
constexpr Value kLargest = static_cast<typename Units::Value>(-1);

template <class Units>
class NarrowTest : public ::testing::Test {
 protected:
  using Requirement = NarrowRequirement<Units>;
  using Provision = NarrowProvision<Units>;

  /// A count of units, dense at both ends and where neighbours meet.
  Value count() {
    if (world.one_in(2)) return world.small();
    return world.one_in(2) ? kLargest<Units> - 1 - world.small() : world.below(kLargest<Units>);
  }
  AttributeSet multiples(unsigned absent, unsigned dynamic) {
    AttributeSet set;
    for (std::size_t i = 0; i < kAttributes; ++i)
      if (!world.one_in(absent))
        set.set(attribute_at(i), count() * unit_of<Units>(attribute_at(i)), world.one_in(dynamic));
    return set;
  }
  /// Anything, often close to a multiple.
  AttributeSet anything(unsigned absent, unsigned dynamic) {
    if (world.one_in(4)) return world.set(absent, dynamic);
    AttributeSet set = multiples(absent, dynamic);
    for (std::size_t i = 0; i < kAttributes; ++i) {
      const Attribute a = attribute_at(i);
      if (set.has(a))
        set.set(a, add_saturating(set[a], world.below(unit_of<Units>(a))), set.is_dynamic(a));
    }
    return set;
  }
  static der::Channel subscriber(const AttributeSet& set) {
    AttributeSet unmarked;
    for (std::size_t i = 0; i < kAttributes; ++i)
      if (set.has(attribute_at(i))) unmarked.set(attribute_at(i), set[attribute_at(i)]);
    return {der::Role::subscriber, 1, unmarked};
  }

  RandomWorld world{31};
};

using AllUnits = ::testing::Types<Units16, Units32, OddUnits>;
class UnitName {
 public:
  template <class Units>
  static std::string GetName(int) {
    if (std::is_same_v<Units, Units16>) return "Units16";
    return std::is_same_v<Units, Units32> ? "Units32" : "OddUnits";
  }
};
TYPED_TEST_SUITE(NarrowTest, AllUnits, UnitName);

TYPED_TEST(NarrowTest, WholeUnitsHaveTheWideOutcome) {
  int seen[3] = {};
  for (int round = 0; round < 100000; ++round) {
    const AttributeSet needs = this->multiples(2, 3);
    const AttributeSet gives = this->multiples(round % 2 == 0 ? 8 : RandomWorld::kNever, 4);
    typename TestFixture::Requirement narrow_needs;
    typename TestFixture::Provision narrow_gives;
    ASSERT_TRUE(to_narrow(needs, &narrow_needs));
    ASSERT_TRUE(to_narrow(gives, &narrow_gives));
    const auto wide = check_layer(needs, gives);
    const NarrowCheck narrow = check_layer(narrow_needs, narrow_gives);
    ASSERT_EQ(narrow.outcome(), wide.outcome);
    ASSERT_EQ(narrow.unfit & narrow.run_time, 0);
    for (std::size_t i = 0; i < wide.count; ++i)
      ASSERT_EQ(narrow.outcome(wide.rows[i].attribute), wide.rows[i].outcome)
          << info(wide.rows[i].attribute).name;
    ++seen[static_cast<int>(wide.outcome)];
  }
  for (const int outcome : seen) EXPECT_GT(outcome, 500);
}

TYPED_TEST(NarrowTest, NoValueGetsABetterOutcome) {
  int granted = 0;
  for (int round = 0; round < 200000; ++round) {
    const AttributeSet needs = this->anything(2, RandomWorld::kNever);
    const AttributeSet gives = this->anything(RandomWorld::kNever, 4);
    typename TestFixture::Requirement narrow_needs;
    typename TestFixture::Provision narrow_gives;
    if (!to_narrow(needs, &narrow_needs)) continue;
    ASSERT_TRUE(to_narrow(gives, &narrow_gives)) << "a provision always has a worse one";
    const Outcome wide = check_layer(needs, gives).outcome;
    const Outcome narrow = check_layer(narrow_needs, narrow_gives).outcome();
    ASSERT_EQ(worse(narrow, wide), narrow);
    granted += narrow == Outcome::fit ? 1 : 0;
  }
  EXPECT_GT(granted, 500);
}

TYPED_TEST(NarrowTest, RequirementsRoundToHarderAndNeverWrap) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    const Value unit = unit_of<TypeParam>(a);
    const bool larger = info(a).better == Better::larger;
    for (int round = 0; round < 3000; ++round) {
      const Value v = this->world.one_in(2) ? this->world.value()
                                            : this->count() * unit + this->world.below(unit);
      const Value expected = larger ? div_up(v, unit) : v / unit;
      typename TestFixture::Requirement narrow;
      const bool fits = to_narrow(AttributeSet().set(a, v), &narrow);
      ASSERT_EQ(fits, expected < kLargest<TypeParam>) << info(a).name << " " << v;
      ASSERT_EQ(narrow.has(a), fits) << "an error leaves the result alone";
      ASSERT_EQ(narrow[a], fits ? expected : 0) << info(a).name << " " << v;
    }
  }
}

TYPED_TEST(NarrowTest, ProvisionsRoundToWorseAndSaturate) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (a == Attribute::deadline) continue;
    const Value unit = unit_of<TypeParam>(a);
    for (int round = 0; round < 3000; ++round) {
      const Value v = this->world.one_in(2) ? this->world.value()
                                            : this->count() * unit + this->world.below(unit);
      const Value stated = a == Attribute::packet_loss ? std::min(v, kCertainLoss) : v;
      const Value exact = info(a).better == Better::larger ? stated / unit : div_up(stated, unit);
      typename TestFixture::Provision narrow;
      ASSERT_TRUE(to_narrow(AttributeSet().set(a, v), &narrow));
      ASSERT_EQ(narrow[a], std::min(exact, kLargest<TypeParam>)) << info(a).name << " " << v;
    }
  }
}

TYPED_TEST(NarrowTest, EncodingsAreReadAsTheSameSet) {
  for (int round = 0; round < 50000; ++round) {
    const der::Channel needs = this->subscriber(this->anything(2, RandomWorld::kNever));
    const der::Channel gives{der::Role::network, 0, this->anything(2, 4)};
    std::uint8_t octets[der::kMaxPlainSize];
    der::NarrowDecoded<TypeParam, Side::requirement> requirement;
    typename TestFixture::Requirement expected;
    const bool fits = to_narrow(needs.attributes, &expected);
    der::Status status =
        der::decode(octets, der::encode(needs, octets, sizeof octets), &requirement);
    ASSERT_EQ(status.error, fits ? der::Error::none : der::Error::range);
    der::NarrowDecoded<TypeParam, Side::provision> provision;
    typename TestFixture::Provision given;
    ASSERT_TRUE(to_narrow(gives.attributes, &given));
    status = der::decode(octets, der::encode(gives, octets, sizeof octets), &provision);
    ASSERT_TRUE(status.ok());
    for (std::uint8_t i = 0; i < kAttributes; ++i) {
      ASSERT_EQ(requirement.attributes.quality(i), expected.quality(i));
      ASSERT_EQ(provision.attributes.quality(i), given.quality(i));
    }
    ASSERT_EQ(requirement.attributes.present(), expected.present());
    ASSERT_EQ(provision.attributes.present(), given.present());
    ASSERT_EQ(provision.attributes.dynamic(), given.dynamic());
  }
}

TYPED_TEST(NarrowTest, UnionOfPublisherAndSubscriberIsTheWideOne) {
  for (int round = 0; round < 50000; ++round) {
    const AttributeSet publisher = this->multiples(2, RandomWorld::kNever);
    const AttributeSet listener = this->multiples(2, RandomWorld::kNever);
    typename TestFixture::Requirement narrow_publisher;
    typename TestFixture::Requirement narrow_listener;
    typename TestFixture::Requirement expected;
    ASSERT_TRUE(to_narrow(publisher, &narrow_publisher));
    ASSERT_TRUE(to_narrow(listener, &narrow_listener));
    ASSERT_TRUE(to_narrow(requirement_between(publisher, listener), &expected));
    const auto both = requirement_between(narrow_publisher, narrow_listener);
    ASSERT_EQ(both.present(), expected.present());
    for (std::uint8_t i = 0; i < kAttributes; ++i)
      ASSERT_EQ(both.quality(i), expected.quality(i)) << kAttributeTable[i].name;
  }
}

TEST(NarrowTest, BoundIsMetExactlyAndMissedByOneUnit) {
  constexpr Value millisecond = 1000000;
  NarrowRequirement<Units16> needs;
  ASSERT_TRUE(to_narrow(AttributeSet().set(Attribute::period, 65534 * millisecond), &needs));
  EXPECT_EQ(needs[Attribute::deadline], 65534U) << "implied by the Period";
  EXPECT_FALSE(to_narrow(AttributeSet().set(Attribute::period, 65535 * millisecond), &needs));
  NarrowProvision<Units16> gives;
  ASSERT_TRUE(to_narrow(AttributeSet().set(Attribute::period, 65534 * millisecond), &gives));
  EXPECT_EQ(check_layer(needs, gives).outcome(), Outcome::fit);
  ASSERT_TRUE(to_narrow(AttributeSet().set(Attribute::period, 65534 * millisecond + 1), &gives));
  EXPECT_EQ(check_layer(needs, gives).outcome(), Outcome::unfit) << "saturated";
  ASSERT_TRUE(to_narrow(AttributeSet().set(Attribute::period, kUnbounded), &gives));
  EXPECT_EQ(check_layer(needs, gives).outcome(Attribute::deadline), Outcome::unfit);
}

// What a small reader refuses beyond what every reader does.
TEST(NarrowDecodeTest, SideMustBeTheRolesOne) {
  const Octets needs = encoding(kSubscriberHead, {0x84, 1, 1});
  const Octets gives = encoding(kNetworkHead, {0x84, 1, 1});
  der::NarrowDecoded<Units16, Side::requirement> requirement;
  der::NarrowDecoded<Units16, Side::provision> provision;
  EXPECT_TRUE(der::decode(needs.data(), needs.size(), &requirement).ok());
  EXPECT_EQ(requirement.subject[7], 0x17);
  EXPECT_TRUE(der::decode(gives.data(), gives.size(), &provision).ok());
  EXPECT_EQ(der::decode(gives.data(), gives.size(), &requirement).error, der::Error::role);
  EXPECT_EQ(der::decode(needs.data(), needs.size(), &provision).error, der::Error::role);
}

TEST(NarrowDecodeTest, UserAttributesAreRefusedAsTheNodeCannotCheckThem) {
  const Octets octets = encoding(kSubscriberHead, {0x84, 1, 1}, element(0x30, user("a")));
  der::NarrowDecoded<Units16, Side::requirement> out;
  out.role = der::Role::publisher;
  const der::Status status = der::decode(octets.data(), octets.size(), &out);
  EXPECT_EQ(status.error, der::Error::user_attributes);
  EXPECT_EQ(status.offset, 2 + 16 + 2 + 3);
  EXPECT_EQ(out.role, der::Role::publisher) << "an error leaves the result alone";
}

TEST(NarrowDecodeTest, RefusesWhateverTheWideReaderRefuses) {
  RandomWorld world(32);
  for (int round = 0; round < 200000; ++round) {
    const RandomChannel channel(world);
    Octets octets = channel.encoded();
    if (!world.one_in(3))
      octets[world.below(octets.size())] = static_cast<std::uint8_t>(world.below(256));
    if (world.one_in(3)) octets.resize(world.below(octets.size()));
    der::Decoded wide;
    const bool understood = der::decode(octets.data(), octets.size(), &wide).ok();
    der::NarrowDecoded<Units32, Side::requirement> requirement;
    der::NarrowDecoded<Units32, Side::provision> provision;
    const bool network = understood && wide.role == der::Role::network;
    const bool plain = understood && wide.user.empty();
    const der::Status status = der::decode(octets.data(), octets.size(), &requirement);
    if (plain && !network)
      ASSERT_TRUE(status.ok() || status.error == der::Error::range) << der::to_text(status.error);
    else
      ASSERT_FALSE(status.ok());
    ASSERT_EQ(der::decode(octets.data(), octets.size(), &provision).ok(), plain && network);
  }
}

}  // namespace
}  // namespace mlcca::testing
