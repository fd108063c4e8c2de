// SPDX-License-Identifier: BSD-2-Clause
// Recordings with frames of Ethernet, alone and beside those of CAN.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/tools/learn/pcap_file.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {
namespace {

using test::event;
using test::kDistance;
using test::PcapFile;
using test::Sent;
using test::station;
using Octets = std::vector<std::uint8_t>;

struct Result {
  std::vector<Sent> sent;
  Interfaces interfaces;
  Left left;
  std::string error;
};

Result read_all(const std::string& file) {
  Result out;
  const auto left = read_recording(
      std::span(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()), "trace",
      out.interfaces, [&](const Frame& f) {
        out.sent.push_back(
            {f.ns, f.interface, f.id, {f.data.begin(), f.data.end()}, f.fd, f.local, f.datagram});
      });
  if (left)
    out.left = *left;
  else
    out.error = left.error().text;
  return out;
}

/// The head that "any" puts in front of a packet.
Octets cooked(unsigned version, std::uint16_t protocol, std::uint32_t index, std::uint16_t device,
              bool outgoing) {
  const auto high = static_cast<std::uint8_t>(protocol >> 8U);
  const auto low = static_cast<std::uint8_t>(protocol);
  const auto type = static_cast<std::uint8_t>(outgoing ? 4 : 0);
  const auto kind = static_cast<std::uint8_t>(device >> 8U);
  const auto of = static_cast<std::uint8_t>(device);
  const auto number = static_cast<std::uint8_t>(index);
  if (version == 1) return {0, type, kind, of, 0, 6, 2, 0, 0, 0, 0, 9, 0, 0, high, low};
  return {high, low, 0, 0, 0, 0, 0, number, kind, of, type, 6, 2, 0, 0, 0, 0, 9, 0, 0};
}
constexpr std::uint16_t kEther = 1;
constexpr std::uint16_t kCanDevice = 280;

Octets join(Octets head, const Octets& tail) {
  head.insert(head.end(), tail.begin(), tail.end());
  return head;
}
const Octets kCanFrame = {0, 0, 1, 0x23, 2, 0, 0, 0, 7, 8};

TEST(EtherRecording, ReadsPcapOfAnEthernetInterface) {
  PcapFile file(1);
  file.add(7'000'000, frame_of(event(0, 0, kDistance, station(7), {1, 2})));
  file.add(8'000'000, frame_of(event(0, 0, kDistance, station(7), {1, 2}), 1));
  Octets tcp = frame_of(event(0, 0, kDistance, station(7), {1, 2}));
  tcp[23] = 6;
  file.add(9'000'000, tcp);
  Octets broken = frame_of(event(0, 0, kDistance, station(7), {1, 2}));
  broken[14] = 0x41;
  file.add(9'000'000, broken);
  const auto is = read_all(file.bytes());
  ASSERT_EQ(is.error, "");
  ASSERT_EQ(is.sent.size(), 2U) << "other traffic is none of ours";
  EXPECT_EQ(is.sent[0].ns, 7'000'000U);
  EXPECT_EQ(is.sent[1].datagram->source, station(7));
  EXPECT_EQ(is.sent[1].data.size(), 11U);
  EXPECT_FALSE(is.sent[0].local) << "such a file does not say it";
  EXPECT_EQ(is.interfaces.names(), std::vector<std::string>{"trace"});
  EXPECT_EQ(is.interfaces.media(), std::vector<Medium>{Medium::ethernet});
  EXPECT_EQ(is.left.lines, 1U);
  EXPECT_TRUE(is.left.first.contains("neither a frame of CAN nor a sound one of IPv4"));
}

TEST(EtherRecording, OfAnyTheFirstFormDoesNotSayWhichInterfaceItWas) {
  PcapFile file(113);
  const auto packet = packet_of(event(0, 0, kDistance, station(7), {1}));
  file.add(1, join(cooked(1, 0x0800, 0, kEther, true), packet));
  file.add(2, join(cooked(1, 0x000c, 0, kCanDevice, false), kCanFrame));
  file.add(3, join(cooked(1, 0x0800, 0, 772, false), packet));  // the loop-back device
  const auto is = read_all(file.bytes());
  ASSERT_EQ(is.error, "");
  ASSERT_EQ(is.sent.size(), 2U);
  EXPECT_TRUE(is.sent[0].local);
  EXPECT_EQ(is.sent[0].datagram->mac, (std::array<std::uint8_t, 6>{2, 0, 0, 0, 0, 9}));
  EXPECT_FALSE(is.sent[1].datagram);
  EXPECT_EQ(is.sent[1].id, 0x123U);
  EXPECT_EQ(is.interfaces.names(), (std::vector<std::string>{"trace", "trace-can"}));
  EXPECT_EQ(is.interfaces.media(), (std::vector<Medium>{Medium::ethernet, Medium::can}));
}

TEST(EtherRecording, OfAnyTheSecondFormDoes) {
  PcapFile file(276);
  const auto packet = packet_of(event(0, 0, kDistance, station(7), {1}));
  file.add(1, join(cooked(2, 0x000c, 3, kCanDevice, true), kCanFrame));
  file.add(2, join(cooked(2, 0x0800, 2, kEther, false), packet));
  file.add(3, join(cooked(2, 0x000c, 4, kCanDevice, false), kCanFrame));
  Octets tagged = cooked(2, 0x8100, 2, kEther, false);
  tagged = join(tagged, {0, 5, 8, 0});
  file.add(4, join(tagged, packet));
  const auto is = read_all(file.bytes());
  ASSERT_EQ(is.error, "");
  ASSERT_EQ(is.sent.size(), 4U);
  EXPECT_TRUE(is.sent[0].local);
  EXPECT_FALSE(is.sent[1].local);
  EXPECT_EQ(is.interfaces.names(), (std::vector<std::string>{"trace-3", "trace-2", "trace-4"}));
}

TEST(EtherRecording, SaysWhichLinkTypesItReads) {
  EXPECT_TRUE(read_all(PcapFile(105).bytes())
                  .error.contains("link type 105 has neither frames of CAN nor of Ethernet"));
}

TEST(EtherRecording, NothingIsReadBeyondTheEndOfAPacket) {
  const auto packet = packet_of(event(0, 0, kDistance, station(7), {1, 2, 3}));
  const std::pair<std::uint32_t, Octets> kinds[] = {
      {1, frame_of(event(0, 0, kDistance, station(7), {1, 2, 3}), 2)},
      {113, join(cooked(1, 0x0800, 0, kEther, false), packet)},
      {276, join(cooked(2, 0x0800, 2, kEther, false), packet)}};
  for (const auto& [link, whole] : kinds)
    for (std::size_t size = 0; size < whole.size(); ++size) {
      PcapFile file(link);
      file.add(1, Octets(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      const auto is = read_all(file.bytes());
      EXPECT_EQ(is.error, "");
      EXPECT_EQ(is.sent.size() + is.left.lines, 1U) << link << " " << size;
    }
}

}  // namespace
}  // namespace mlcca::learn
