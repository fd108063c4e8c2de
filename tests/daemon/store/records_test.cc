// SPDX-License-Identifier: BSD-2-Clause
// What the journal keeps of grants and slots is all that they say.
#include "daemon/store/records.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

namespace mlcca::store::test {
namespace {

using gates::Direction;
using gates::PlacedSlot;
using gates::SlotSpec;

template <class Integer>
Integer most() {
  return std::numeric_limits<Integer>::max();
}

/// Of 7 bits as often as of 64: octets more or less.
std::uint64_t any(std::mt19937_64& random) { return random() >> (random() % 64); }

PlacedSlot random_slot(std::mt19937_64& random) {
  PlacedSlot placed;
  placed.ifindex = static_cast<std::uint32_t>(any(random));
  SlotSpec& s = placed.slot;
  s.direction = random() % 2 == 0 ? Direction::ingress : Direction::egress;
  s.pass = random() % 2 == 0;
  s.max_len = static_cast<std::uint16_t>(any(random));
  s.formats = static_cast<std::uint8_t>(any(random));
  s.id = static_cast<std::uint32_t>(any(random));
  s.mask = static_cast<std::uint32_t>(any(random));
  s.source = static_cast<std::uint32_t>(any(random));
  s.origin = static_cast<std::uint32_t>(any(random));
  s.uid = random() % 3 == 0 ? GATE_ANY_UID : static_cast<std::uint32_t>(any(random));
  s.station = any(random);
  s.subject = 7;
  s.per_frame = any(random);
  s.per_byte = any(random);
  s.tolerance = any(random);
  s.excess_passes = random() % 2 == 0;
  s.period = any(random);
  s.silence = any(random);
  s.together = any(random);
  return placed;
}

TEST(SlotRecord, GivesBackEverythingThatASlotSays) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 10'000; ++i) {
    const std::vector<PlacedSlot> slots(random() % 4, random_slot(random));
    EXPECT_EQ(slots_in(record_of(slots), 7), slots);
  }
}

TEST(SlotRecord, TakesTheLargestNumbers) {
  PlacedSlot slot{most<std::uint32_t>(), {}};
  slot.slot.id = slot.slot.mask = slot.slot.source = slot.slot.origin = most<std::uint32_t>();
  slot.slot.tolerance = most<std::uint64_t>();
  EXPECT_EQ(slots_in(record_of({&slot, 1}), 0), std::vector{slot});
}

TEST(SlotRecord, OfNothingIsEmpty) {
  EXPECT_EQ(record_of(std::vector<PlacedSlot>{}), "");
  EXPECT_EQ(slots_in("", 1), std::vector<PlacedSlot>{});
}

TEST(SlotRecord, CutOffAnywhereIsNotUnderstood) {
  std::mt19937_64 random(2);
  const PlacedSlot slot = random_slot(random);
  const std::string record = record_of({&slot, 1});
  for (std::size_t n = 1; n < record.size(); ++n)
    EXPECT_FALSE(slots_in(record.substr(0, n), 7)) << n;
}

TEST(SlotRecord, NumbersThatDoNotFitAreNotUnderstood) {
  const auto of_one = [](const std::string& slot) {
    return slots_in("\x0a" + std::string(1, static_cast<char>(slot.size())) + slot, 0);
  };
  EXPECT_TRUE(of_one("\x28\xff\xff\x03")) << "a length of 16 bits";
  EXPECT_FALSE(of_one("\x28\xff\xff\x07")) << "of 17";
  EXPECT_TRUE(of_one("\x30\xff\x01")) << "formats of 8 bits";
  EXPECT_FALSE(of_one("\x30\xff\x03")) << "of 9";
  EXPECT_FALSE(of_one("\x60" + std::string(10, '\xff') + '\x01')) << "11 octets are no number";
  EXPECT_FALSE(of_one("\x98\x01\x01")) << "a field that no version has written yet";
}

TEST(GrantRecord, GivesBackEverythingThatIsGranted) {
  const core::Grants grants{3, {{"camera", 0, "control"}, {"Größe #1>2", ~0ULL, "lap top"}}};
  EXPECT_EQ(grants_in(record_of(grants)), grants);
  EXPECT_EQ(record_of(core::Grants{}), "");
  EXPECT_FALSE(grants_in("set=0 camera#0>control"));
}

}  // namespace
}  // namespace mlcca::store::test
