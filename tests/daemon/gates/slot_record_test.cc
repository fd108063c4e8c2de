// SPDX-License-Identifier: BSD-2-Clause
// What the journal keeps of slots is all that they say.
#include "daemon/gates/slot_record.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

namespace mlcca::enforce {
namespace {

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
  const bool origin = gate_has_origin(static_cast<std::uint32_t>(s.direction), s.source) != 0;
  (origin ? s.origin : s.uid) = static_cast<std::uint32_t>(any(random));
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
  EXPECT_EQ(record_of({}), "");
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
  const PlacedSlot slot;
  const std::string good = record_of({&slot, 1});
  const auto with = [&](std::size_t at, const std::string& octets) {
    return slots_in(good.substr(0, at) + octets + good.substr(at + 1), 0);
  };
  EXPECT_TRUE(with(0, "\xff\xff\xff\xff\x0f")) << "an ifindex of 32 bits";
  EXPECT_FALSE(with(0, "\xff\xff\xff\xff\x1f")) << "of 33";
  EXPECT_TRUE(with(1, "\x07"));
  EXPECT_FALSE(with(1, "\x08")) << "what nobody has written yet";
  EXPECT_TRUE(with(2, "\xff\xff\x03")) << "a length of 16 bits";
  EXPECT_FALSE(with(2, "\xff\xff\x07")) << "of 17";
  EXPECT_FALSE(with(8, std::string(10, '\xff') + '\x01')) << "11 octets are no number";
}

}  // namespace
}  // namespace mlcca::enforce
