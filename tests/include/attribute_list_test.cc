// SPDX-License-Identifier: BSD-2-Clause
// Lists of attributes as types, and the sets that they are.
#include "mlcca/attribute_list.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace mlcca {
namespace {

template <Value V>
struct Temperature : UserAttribute<Temperature, V, Better::smaller, Composition::slowest> {};

TEST(AttributeListTest, EachAttributeSetsItsOwnEntry) {
  const AttributeSet set =
      make_set<Latency<1_ns>, Jitter<2_ns>, Deadline<3_ns>, Period<4_ns>, Bandwidth<5_bytes_per_s>,
               PacketLoss<6_ppb>, Omission<7>, MaxPayload<8_bytes>>();
  for (std::size_t i = 0; i < kAttributes; ++i) {
    EXPECT_TRUE(set.has(attribute_at(i)));
    EXPECT_FALSE(set.is_dynamic(attribute_at(i)));
    EXPECT_EQ(set[attribute_at(i)], i + 1);
  }
}

TEST(AttributeListTest, AnEmptyListIsTheEmptySet) {
  EXPECT_TRUE(AttributeList<>::set().empty());
  EXPECT_TRUE(make_set<>().empty());
}

TEST(AttributeListTest, OrderDoesNotMatterToTheSet) {
  EXPECT_EQ((make_set<Omission<2>, Period<50_ms>>()), (make_set<Period<50_ms>, Omission<2>>()));
}

TEST(AttributeListTest, DynamicMarksABestCase) {
  const AttributeSet set = make_set<Dynamic<Bandwidth<24_Mbit_per_s>>, Latency<1_ms>>();
  EXPECT_TRUE(set.is_dynamic(Attribute::bandwidth));
  EXPECT_FALSE(set.is_dynamic(Attribute::latency));
  EXPECT_EQ(set[Attribute::bandwidth], 3000000U);
}

TEST(AttributeListTest, AttributesOfTheUsersOwnAreNotInTheSet) {
  using List = AttributeList<Temperature<300>, Omission<2>, Dynamic<Temperature<301>>>;
  EXPECT_EQ(List::set(), make_set<Omission<2>>());
  EXPECT_EQ(List::kList.users, 2);
}

TEST(AttributeListTest, AListIsItsOwnTypeAsInFamouso) {
  using List = AttributeList<Period<50_ms>, Omission<2>>;
  EXPECT_TRUE((std::is_same_v<List, List::type>));
}

}  // namespace
}  // namespace mlcca
