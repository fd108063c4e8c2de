// SPDX-License-Identifier: BSD-2-Clause
// Messages of J1939 that are longer than a frame.
#include <gtest/gtest.h>

#include "core/model/medium.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

Network truck_bus() {
  Network n;
  n.profile = Profile::j1939;
  return n;
}
Binding bound(std::uint32_t pgn) {
  Binding b;
  b.id = pgn;
  b.extended = true;
  return b;
}
FrameIdentity identity_on(const Network& network, const Binding& binding, bool fragmented = true) {
  Publisher p;
  p.node = 5;
  return identity_of(p, network, binding, fragmented).value_or(FrameIdentity{});
}

TEST(J1939Message, IsAnnouncedAndFollowsInPacketsOfSeven) {
  const auto network = truck_bus();
  auto b = bound(0xfeca);
  EXPECT_EQ(frames_per_event(network, &b, 8), 1U);
  EXPECT_EQ(transport_of(network, &b, 8), nullptr);
  EXPECT_EQ(frames_per_event(network, &b, 9), 3U);
  EXPECT_EQ(frames_per_event(network, &b, 20), 4U);
  EXPECT_EQ(frames_per_event(network, &b, 1785), 256U);
  EXPECT_EQ(event_bytes(network, b), 1785U);
  EXPECT_EQ(frame_bytes(network, b, 20), 8U);
  ASSERT_NE(transport_of(network, &b, 9), nullptr);
  EXPECT_EQ(identity_on(network, b), identity_on(network, b, false));
  const auto carriers = transport_of(network, &b, 9)->carriers(identity_on(network, b));
  EXPECT_EQ(carriers[0].id, kExtendedFlag | 0x00ecff05);
  EXPECT_EQ(carriers[1].id, kExtendedFlag | 0x00ebff05);
  EXPECT_EQ(carriers[0].mask, kExtendedFlag | 0x03ffffff) << "the priority is open";
}

TEST(J1939Message, IsBroadcastInClassicFrames) {
  const auto network = truck_bus();
  auto b = bound(0xef00);
  EXPECT_EQ(event_bytes(network, b), 1785U);
  const auto carriers = transport_of(network, &b, 9)->carriers(identity_on(network, b));
  EXPECT_EQ(carriers[1].mask & 0xff00U, 0xff00U) << "though the destination of its PGN is open";
  b.destination = 0xff;
  EXPECT_EQ(event_bytes(network, b), 1785U);
  b.destination = 0x21;
  EXPECT_EQ(event_bytes(network, b), 8U) << "RTS and CTS";
  EXPECT_FALSE(is_fragmented(network, &b, 9));
  b = bound(0xfeca);
  for (const auto format : {FrameFormat::fd, FrameFormat::any}) {
    b.format = format;
    EXPECT_EQ(event_bytes(network, b), 64U);
  }
}

}  // namespace
}  // namespace mlcca::core
