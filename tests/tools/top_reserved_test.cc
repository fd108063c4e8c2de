// SPDX-License-Identifier: BSD-2-Clause
// What `top` shows as reserved, held against what `reservations` lists, and what nobody counts.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tools/top/sample.hpp"

namespace mlcca::tools::top {
namespace {

control::Channel delivery(const std::string& name, const std::string& to,
                          std::vector<std::string> route) {
  control::Channel c;
  c.name = name;
  c.publisher = "p-" + name;
  c.from = route.front();
  c.to = to;
  c.route = std::move(route);
  c.granted = true;
  return c;
}

control::Reservation holds(const std::string& channel, std::uint64_t amount,
                           std::uint64_t admission = 0) {
  control::Reservation r;
  r.channel = channel;
  r.publisher = "p-" + channel;
  r.amount = amount;
  r.admission = admission;
  return r;
}

control::Resource bus(const std::string& name, std::vector<control::Reservation> all) {
  control::Resource r{.name = name + ": bus time",
                      .kind = "bus",
                      .unit = "ppm",
                      .capacity_known = true,
                      .capacity = 1'000'000,
                      .reserved = 0,
                      .background = 0,
                      .reservations = std::move(all)};
  for (const auto& one : r.reservations) r.reserved += one.amount;
  return r;
}

/// Two channels over two buses; the publisher of the one has two flows on the second bus.
TEST(TopReserved, IsWhatReservationsListForTheWay) {
  Sample now;
  now.channels.channels = {delivery("beat", "right", {"left", "bridge", "right"}),
                           delivery("near", "left", {"left"}),
                           delivery("near", "right", {"left", "bridge", "right"})};
  now.reservations.resources = {
      bus("left", {holds("beat", 20'000), holds("near", 30'000)}),
      bus("right", {holds("beat", 10'000), holds("near", 40'000), holds("near", 50'000)})};
  for (const std::string name : {"left", "right"}) {
    control::Network network;
    network.name = name;
    now.networks.networks.push_back(network);
  }
  const auto rows = rows_by_subject(nullptr, now);
  EXPECT_DOUBLE_EQ(rows[0].reserved.value(), 0.02);
  EXPECT_DOUBLE_EQ(rows[1].reserved.value(), 0.03) << "what it holds elsewhere is of another way";
  EXPECT_DOUBLE_EQ(rows[2].reserved.value(), 0.09) << "both of its flows there";
  const auto networks = rows_by_network(nullptr, now);
  ASSERT_EQ(networks.size(), 2U);
  for (std::size_t i = 0; i < networks.size(); ++i)
    EXPECT_DOUBLE_EQ(networks[i].reserved.value(),
                     static_cast<double>(now.reservations.resources[i].reserved) / 1e6);
}

TEST(TopReserved, EachAdmissionHoldsWhatItHolds) {
  Sample now;
  auto first = delivery("beat", "left", {"left"});
  first.admission = 7;
  auto second = first;
  second.admission = 8;
  auto described = first;
  described.admission = 0;
  now.channels.channels = {first, second, described};
  now.reservations.resources = {
      bus("left", {holds("beat", 10'000, 7), holds("beat", 20'000, 8), holds("beat", 30'000)})};
  const auto rows = rows_by_subject(nullptr, now);
  EXPECT_DOUBLE_EQ(rows[0].reserved.value(), 0.01);
  EXPECT_DOUBLE_EQ(rows[1].reserved.value(), 0.02);
  EXPECT_DOUBLE_EQ(rows[2].reserved.value(), 0.03);
}

/// The admission of the delivery is that of its subscriber.
TEST(TopReserved, ADescribedPublisherHoldsForWhoIsAdmitted) {
  Sample now;
  auto joined = delivery("beat", "left", {"left"});
  joined.admission = 7;
  now.channels.channels = {joined};
  now.reservations.resources = {bus("left", {holds("beat", 10'000)})};
  EXPECT_DOUBLE_EQ(rows_by_subject(nullptr, now).at(0).reserved.value(), 0.01);
}

TEST(TopRatesTest, OfEventsThatNobodyCountsTheRateIsNotKnown) {
  Sample before;
  before.at_ns = 10'000'000'000;
  before.channels.channels = {delivery("beat", "b", {"a", "b"})};
  before.channels.channels[0].crosses_no_gate = true;
  Sample now = before;
  now.at_ns += 2'000'000'000;
  EXPECT_FALSE(rows_by_subject(&before, now).at(0).rate);
}

}  // namespace
}  // namespace mlcca::tools::top
