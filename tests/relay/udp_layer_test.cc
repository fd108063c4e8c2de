// SPDX-License-Identifier: BSD-2-Clause
// Datagrams of events, as FAMOUSO's own programs send them.
#include "relay/layers/udp_layer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::relay {
namespace {

std::uint64_t subject_of(const std::string& text) {
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < 8; ++i)
    out = out << 8U | (i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0U);
  return out;
}

std::string group(std::uint64_t subject) {
  const std::uint32_t g = group_of(subject);
  return std::to_string(g >> 24U) + '.' + std::to_string(g >> 16U & 0xffU) + '.' +
         std::to_string(g >> 8U & 0xffU) + '.' + std::to_string(g & 0xffU);
}

TEST(UdpLayerTest, TheGroupsAreThoseOfTheReference) {
  EXPECT_EQ(group(subject_of("SUBSCRIB")), "239.83.66.82");
  EXPECT_EQ(group(subject_of("Distance")), "239.68.101.110");
  EXPECT_EQ(group(subject_of("Velocity")), "239.86.121.105");
  EXPECT_EQ(group(subject_of("ManChan!")), "239.77.33.97");
  EXPECT_EQ(group(0xf100000000000000), "239.241.0.1");
  EXPECT_EQ(group(0xf100000000ff0000), "239.241.0.254");
}

TEST(UdpLayerTest, ADatagramIsSubjectFlagAndData) {
  const auto header = datagram_header(subject_of("Velocity"), true);
  EXPECT_EQ(std::string(header.begin(), header.end()), std::string("Velocity\1"));
  std::vector<std::uint8_t> octets(header.begin(), header.end());
  octets.insert(octets.end(), {1, 2, 3});
  const auto read = parse_datagram(octets);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->subject, subject_of("Velocity"));
  EXPECT_TRUE(read->is_fragment);
  EXPECT_EQ(std::vector(read->data.begin(), read->data.end()),
            (std::vector<std::uint8_t>{1, 2, 3}));
  octets[8] = 0;
  EXPECT_FALSE(parse_datagram(octets)->is_fragment);
  octets[8] = 2;
  EXPECT_FALSE(parse_datagram(octets));
  octets.resize(9);
  octets[8] = 0;
  ASSERT_TRUE(parse_datagram(octets));
  EXPECT_TRUE(parse_datagram(octets)->data.empty());
  octets.resize(8);
  EXPECT_FALSE(parse_datagram(octets)) << "FAMOUSO's own receiver crashes at it";
}

/// A socket that has received datagrams, each from the same address.
class ReceivedDatagrams : public UdpSocket {
 public:
  explicit ReceivedDatagrams(std::vector<std::vector<std::uint8_t>> datagrams)
      : datagrams_(std::move(datagrams)) {}
  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] Result<void> join(std::uint32_t /*group*/) override { return {}; }
  void leave(std::uint32_t /*group*/) override {}
  Got receive(Datagram& to) override {
    if (next_ == datagrams_.size()) return Got::nothing;
    to = {.octets = datagrams_[next_++], .from = 0x0a000001, .unix_ns = 1};
    return Got::datagram;
  }
  [[nodiscard]] bool pending() const override { return next_ != datagrams_.size(); }
  void read_errors() override {}
  Sent send(std::uint32_t /*to*/, Octets /*header*/, Octets /*data*/) override {
    return Sent::failed;
  }
  [[nodiscard]] std::uint32_t own_address() const override { return 0; }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

 private:
  std::vector<std::vector<std::uint8_t>> datagrams_;
  std::size_t next_ = 0;
};

/// FAMOUSO's own programs number their events from 0 whenever they start.
TEST(UdpLayerTest, OfASenderThatStartsAgainEveryEventComesOrIsCounted) {
  const std::uint64_t subject = subject_of("Velocity");
  const auto header = datagram_header(subject, true);
  std::vector<std::vector<std::uint8_t>> datagrams;
  constexpr std::uint32_t events = 4;
  for (std::uint8_t run = 0; run < 3; ++run)
    for (std::uint32_t number = 0; number < events; ++number) {
      // The last run sends what the one before has sent.
      const std::vector<std::uint8_t> event(10'000, std::min<std::uint8_t>(run, 1));
      auto fragments = afp::Fragments::of(afp::kUdp, event, number).value();
      while (const auto fragment = fragments.next()) {
        datagrams.emplace_back(header.begin(), header.end());
        datagrams.back().insert(datagrams.back().end(), fragment->begin(), fragment->end());
      }
    }
  UdpLayer layer(std::make_unique<ReceivedDatagrams>(std::move(datagrams)), false);
  ASSERT_TRUE(layer.follow(1, {}, subject, 20'000));
  std::uint64_t came = 0;
  EXPECT_TRUE(layer.receive(1'000, [&came](const Layer::Arrival&) { ++came; }));
  EXPECT_EQ(came, 2 * events);
  EXPECT_EQ(layer.losses().all(), events);
}

}  // namespace
}  // namespace mlcca::relay
