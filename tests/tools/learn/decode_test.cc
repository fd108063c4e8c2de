// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/decode.hpp"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <vector>

#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

/// Events of these frames.
std::vector<Event> decoded(Decoder& decoder, const std::vector<test::Sent>& sent) {
  std::vector<Event> out;
  for (const auto& one : sent)
    decoder.take(one.frame(), [&](const Event& event) { out.push_back(event); });
  return out;
}

test::Sent famouso(std::uint32_t tag, std::vector<std::uint8_t> data) {
  return {0, 0, kExtended | 0x7dU << 22U | 5U << 14U | tag, std::move(data)};
}
/// What the broker says of a tag.
test::Sent dealt(std::uint32_t tag, std::uint8_t half, const std::string& text) {
  std::vector<std::uint8_t> data = {5, half, static_cast<std::uint8_t>(tag >> 8U),
                                    static_cast<std::uint8_t>(tag)};
  data.insert(data.end(), text.begin(), text.end());
  return {0, 0, kExtended | 0x1f5fc004U, std::move(data)};
}

TEST(Decoder, EventsOfFamousoHaveThePriorityThatManagementHas) {
  Decoder decoder(core::Profile::famouso);
  const auto events = decoded(decoder, {famouso(0x100, {1, 2}), famouso(0x101, {})});
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].number, 0x100U);
  EXPECT_EQ(events[0].node, 5U);
  EXPECT_EQ(decoder.lost_control_frames(), 0U);
}

TEST(Decoder, TheTagOfSubscriptionsIsTheOneThatTheBrokerDeals) {
  Decoder decoder(core::Profile::famouso);
  EXPECT_TRUE(decoded(decoder, {famouso(0x3fff, {1})}).empty()) << "it is dealt first";
  EXPECT_TRUE(decoded(decoder, {dealt(0x3ffe, 0, "SUBS"), dealt(0x3ffe, 1, "CRIX"),
                                dealt(0x200, 0, "SUBS"), dealt(0x200, 1, "CRIB")})
                  .empty());
  EXPECT_TRUE(decoded(decoder, {famouso(0x200, {1})}).empty());
  EXPECT_EQ(decoded(decoder, {famouso(0x3fff, {1}), famouso(0x3ffe, {1})}).size(), 2U);
}

TEST(Decoder, HeartBeatsOfCanopenAreControlTrafficThatAChannelCanCarry) {
  Decoder decoder(core::Profile::canopen);
  constexpr std::array<std::uint8_t, 2> state = {5, 0};
  std::vector<Event> events;
  const auto take = [&](std::uint32_t id, std::size_t bytes) {
    Frame frame;
    frame.id = id;
    frame.data = std::span(state).first(bytes);
    decoder.take(frame, [&](const Event& event) { events.push_back(event); });
  };
  take(0x701, 1);
  take(0x181, 2);
  take(0x080, 0);
  take(0x702 | kRemote, 1);  // node guarding
  ASSERT_EQ(events.size(), 2U);
  EXPECT_TRUE(events[0].control);
  EXPECT_FALSE(events[1].control);
  EXPECT_EQ(decoder.lost_control_frames(), 2U);
}

}  // namespace
}  // namespace mlcca::learn
