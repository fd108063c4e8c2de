// SPDX-License-Identifier: BSD-2-Clause
// Described publishers and buses, as the analysis has them.
#include "core/can/of_system.hpp"

#include <gtest/gtest.h>

namespace mlcca::core::can {
namespace {

constexpr Timing kTiming{.bitrate = 500'000, .data_bitrate = 2'000'000};
constexpr Time kPeriod = 10'000'000;

/// One channel with events of so many bytes, bound on one bus.
System described(Profile profile, FrameFormat format, Value bytes, bool extended) {
  System system;
  system.channels.resize(1);
  Network bus;
  bus.profile = profile;
  Binding binding;
  binding.id = 0x64;
  binding.extended = extended;
  binding.format = format;
  bus.bindings = {binding};
  system.networks = {bus};
  Publisher p;
  p.node = 5;
  p.attributes.set(Attribute::period, kPeriod).set(Attribute::max_payload, bytes);
  system.publishers = {p};
  return system;
}

Message made(const System& system, const Timing& timing = kTiming) {
  const auto m = message_of(system, system.publishers[0], 0, 0, timing);
  EXPECT_TRUE(m);
  return m.value_or(Message{});
}

Time time_of(bool fd, unsigned bytes, bool extended = false, const Timing& timing = kTiming) {
  return frame_time(timing, {.extended = extended, .fd = fd}, bytes);
}

TEST(OfSystem, AFrameTakesTheTimeOfItsFormat) {
  for (const bool extended : {false, true}) {
    const auto classic = made(described(Profile::raw, FrameFormat::classic, 8, extended));
    EXPECT_EQ(classic.transmission, time_of(false, 8, extended));
    EXPECT_EQ(classic.last_frame, classic.transmission);
    EXPECT_EQ(classic.longest_frame, classic.transmission);
    EXPECT_EQ(classic.frames, 1U);
    const auto fd = made(described(Profile::raw, FrameFormat::fd, 9, extended));
    EXPECT_EQ(fd.transmission, time_of(true, 12, extended));
  }
  EXPECT_EQ(made(described(Profile::raw, FrameFormat::xl, 100, false)).transmission,
            xl_frame_time(kTiming, 100));
}

TEST(OfSystem, AMessageOfJ1939IsItsNodesWithPausesBetweenTheFrames) {
  System system = described(Profile::j1939, FrameFormat::classic, 20, true);
  system.networks[0].bindings[0].id = 0xfeca;
  system.networks[0].bindings[0].priority = 6;
  const auto m = made(system);
  EXPECT_EQ(m.frames, 4U) << "an announcement and three packets";
  EXPECT_EQ(m.transmission, 4 * time_of(false, 8, true));
  EXPECT_EQ(m.last_frame, time_of(false, 8, true)) << "the last packet is filled up";
  EXPECT_FALSE(m.back_to_back);
  EXPECT_EQ(m.pauses, 3 * 200'000'000U);
  EXPECT_EQ(m.least_pause, 50'000'000U);
  EXPECT_EQ(m.sender, 5U);
  // Packets win against announcements, and these against an event that fits a frame.
  EXPECT_EQ(m.priority, arbitration(0x18ebff05, true));
  EXPECT_EQ(m.lowest_priority, arbitration(0x18feca05, true));
  system.networks[0].bindings[0].priority = std::nullopt;
  EXPECT_EQ(made(system).priority, arbitration(0x00ebff05, true));
  EXPECT_EQ(made(system).lowest_priority, arbitration(0x1cfeca05, true));
  const auto in_a_frame = made(described(Profile::j1939, FrameFormat::classic, 8, true));
  EXPECT_EQ(in_a_frame.pauses, 0U);
  EXPECT_EQ(in_a_frame.sender, kNoSender);
}

TEST(OfSystem, WhereTheFormatIsOpenTheLongerFrameCounts) {
  // Without a faster data phase an FD frame is longer, with a fast one a long classic frame is.
  const System system = described(Profile::raw, FrameFormat::any, 8, false);
  const Timing slow{.bitrate = 500'000, .data_bitrate = 500'000};
  const Timing fast{.bitrate = 500'000, .data_bitrate = 8'000'000};
  ASSERT_GT(time_of(true, 8, false, slow), time_of(false, 8, false, slow));
  ASSERT_LT(time_of(true, 8, false, fast), time_of(false, 8, false, fast));
  EXPECT_EQ(made(system, slow).transmission, time_of(true, 8, false, slow));
  EXPECT_EQ(made(system, fast).transmission, time_of(false, 8, false, fast));
}

TEST(OfSystem, AnEventOfSeveralFramesTakesAllOfThem) {
  // FAMOUSO: 7 bytes a frame, so 20 bytes are two full frames and one of 6 with its header of 1.
  const auto m = made(described(Profile::famouso, FrameFormat::classic, 20, true));
  EXPECT_EQ(m.frames, 3U);
  EXPECT_EQ(m.longest_frame, time_of(false, 8, true));
  EXPECT_EQ(m.last_frame, time_of(false, 7, true));
  EXPECT_EQ(m.transmission, 2 * time_of(false, 8, true) + time_of(false, 7, true));
  const auto full = made(described(Profile::famouso, FrameFormat::classic, 21, true));
  EXPECT_EQ(full.frames, 3U);
  EXPECT_EQ(full.transmission, 3 * time_of(false, 8, true));
}

TEST(OfSystem, OfManyFramesTheLastMayBeAnyAndAllCountAsFull) {
  // Beyond 32 fragments which one is short is not relied on.
  const auto m = made(described(Profile::famouso, FrameFormat::classic, 32 * 7 + 1, true));
  EXPECT_EQ(m.frames, 33U);
  EXPECT_EQ(m.transmission, 33 * time_of(false, 8, true));
  EXPECT_EQ(m.last_frame, time_of(false, 1, true)) << "the shortest that carries anything";
}

TEST(OfSystem, OfAnOpenFormatTheLastFrameIsTheShorterAndTheWholeTheLonger) {
  const Timing fast{.bitrate = 500'000, .data_bitrate = 8'000'000};
  const auto m = made(described(Profile::famouso, FrameFormat::any, 80, true), fast);
  EXPECT_EQ(m.frames, 2U);
  // 63 bytes in the first frame, 17 and a header in the second, which goes into 20.
  ASSERT_GT(time_of(false, 8, true, fast), time_of(true, 20, true, fast));
  EXPECT_EQ(m.last_frame, std::min(time_of(false, 8, true, fast), time_of(true, 18, true, fast)));
  EXPECT_EQ(m.transmission, m.longest_frame + std::max(time_of(false, 8, true, fast),
                                                       time_of(true, 18, true, fast)));
}

TEST(OfSystem, WhereTheSizeIsNotStatedAnEventIsOneLongestFrame) {
  System system = described(Profile::raw, FrameFormat::classic, 8, false);
  system.publishers[0].attributes.clear(Attribute::max_payload);
  EXPECT_EQ(made(system).transmission, time_of(false, 8));
}

TEST(OfSystem, PriorityAndTimesAreThoseOfThePublisher) {
  System system = described(Profile::raw, FrameFormat::classic, 8, false);
  const auto m = made(system);
  EXPECT_EQ(m.priority, arbitration(0x64, false));
  EXPECT_EQ(m.lowest_priority, 0U) << "all frames have the same";
  EXPECT_EQ(m.period, kPeriod);
  EXPECT_EQ(m.deadline, kPeriod);
  EXPECT_EQ(m.jitter, 0U);
  system.publishers[0].attributes.set(Attribute::jitter, 7);
  EXPECT_EQ(made(system).jitter, 7U);
  system.networks[0].bindings[0].mask = 0x7fc;
  EXPECT_EQ(made(system).lowest_priority, arbitration(0x67, false));
}

TEST(OfSystem, ThereIsNoMessageOfWhatIsNotKnown) {
  const System good = described(Profile::famouso, FrameFormat::classic, 8, true);
  const auto is_message = [](const System& system, const Timing& timing = kTiming) {
    return message_of(system, system.publishers[0], 0, 0, timing).has_value();
  };
  EXPECT_TRUE(is_message(good));
  EXPECT_FALSE(is_message(good, {})) << "no bit rate";
  System system = good;
  system.publishers[0].attributes.clear(Attribute::period);
  EXPECT_FALSE(is_message(system));
  system = good;
  system.publishers[0].node.reset();
  EXPECT_FALSE(is_message(system)) << "no node, which its identifier names";
  system = good;
  system.networks[0].bindings.clear();
  EXPECT_FALSE(is_message(system));
  system = good;
  system.networks[0].kind = NetworkKind::udp_multicast;
  EXPECT_FALSE(is_message(system));
}

TEST(OfSystem, ABusIsAssumedAsItIsDescribed) {
  System system = described(Profile::raw, FrameFormat::classic, 8, false);
  CanBus& bus = system.networks[0].bus;
  bus = {.bitrate = 500'000,
         .data_bitrate = 0,
         .unknown_senders = true,
         .background = 3,
         .faults = {.count = 2, .interval = 9}};
  system.networks.push_back(system.networks[0]);
  for (const std::size_t network : {1, 0, 0}) {
    Port& port = system.gateways.emplace_back().ports.emplace_back();
    port.network = network;
    port.queueing = Queueing::priority;
    port.fifo_depth = static_cast<std::uint32_t>(system.gateways.size());
    port.queue_length = 20;
  }
  EXPECT_EQ(timing_of(system.networks[0]), (Timing{.bitrate = 500'000, .data_bitrate = 0}));
  Assumptions expected;
  expected.timing = {.bitrate = 500'000};
  expected.unknown_senders = true;
  expected.background = 3;
  expected.faults = {.count = 2, .interval = 9};
  for (const std::uint32_t depth : {2, 3})
    expected.queues.push_back({.queueing = Queueing::priority, .fifo_depth = depth, .length = 20});
  EXPECT_EQ(assumptions_of(system, 0, timing_of(system.networks[0])), expected);
}

TEST(OfSystem, FdAndXlFramesAreExpectedWhereTheyMayOccur) {
  System system = described(Profile::raw, FrameFormat::classic, 8, false);
  const auto assumed = [&](const Timing& timing) { return assumptions_of(system, 0, timing); };
  const Timing classic{.bitrate = 500'000};
  EXPECT_FALSE(assumed(classic).fd_frames);
  EXPECT_TRUE(assumed({.bitrate = 500'000, .data_bitrate = 1}).fd_frames);
  EXPECT_FALSE(assumed({.bitrate = 500'000, .data_bitrate = 1}).xl_frames);
  system.networks[0].bindings[0].format = FrameFormat::any;
  EXPECT_TRUE(assumed(classic).fd_frames);
  EXPECT_FALSE(assumed(classic).xl_frames);
  system.networks[0].bindings[0].format = FrameFormat::xl;
  EXPECT_TRUE(assumed(classic).xl_frames);
}

}  // namespace
}  // namespace mlcca::core::can
