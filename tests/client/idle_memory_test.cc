// SPDX-License-Identifier: BSD-2-Clause
// What a channel takes of memory while nothing is sent: a program may have thousands of them.
#include <gtest/gtest.h>
#include <malloc.h>
#include <net/if.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "tests/client/scene.hpp"

namespace mlcca::client {
namespace {

/// As mlccad answers it for a channel to a network: each attribute is held against two places.
control::Reply answer_of_a_gateway() {
  control::Channel granted = delivery("field", true);
  granted.from = "panel";
  granted.reason = "Omission 2 required, the route provides 1 (1 to spare)";
  granted.route = {"panel", "field"};
  const control::Row row = granted.rows.front();
  for (const char* attribute : {"Latency", "Deadline", "Period", "MaxPayload"})
    for (const char* where : {"capacity of field", "end to end"}) {
      control::Row other = row;
      other.attribute = attribute;
      other.unit = std::string(attribute) == "MaxPayload" ? "bytes" : "ns";
      other.where = where;
      other.margin = "12.5 ms to spare";
      granted.rows.push_back(other);
    }
  control::Endpoint field;
  field.network = "field";
  field.interface = "lo";
  field.ifindex = ::if_nametoindex("lo");
  field.frame_bytes = 1'000;
  return {0, control::Channels{{granted}, 0, {field}}};
}

TEST(IdleMemory, AnIdleChannelTakesAKibibyteAtMost) {
  constexpr std::size_t channels = 200;
  Scene scene({{{answer_of_a_gateway()}}});
  Client client(scene.options());
  PublisherChannel first(client, "first channel");
  // The scene keeps each request. Their list has room for what follows.
  for (int i = 0; i < 520; ++i) ASSERT_EQ(first.announce()->state, State::granted);
  const std::size_t begin = ::mallinfo2().uordblks;
  for (std::size_t i = 0; i < channels; ++i) first.announce();
  const std::size_t of_requests = ::mallinfo2().uordblks - begin;
  std::vector<std::unique_ptr<PublisherChannel>> all;
  all.reserve(channels);
  const std::size_t before = ::mallinfo2().uordblks;
  for (std::size_t i = 0; i < channels; ++i) {
    all.push_back(std::make_unique<PublisherChannel>(client, "idle channel"));
    all.back()->announce();
  }
  client.process();
  const std::size_t grown = ::mallinfo2().uordblks - before;
  EXPECT_LE((grown - std::min(grown, of_requests)) / channels, 1'024U);
  // Nothing of the answer is lost by that.
  const auto answer = all.back()->answer();
  ASSERT_EQ(answer->deliveries.size(), 1U);
  const Delivery& kept = answer->deliveries[0];
  EXPECT_EQ(answer->reason, kept.reason);
  EXPECT_EQ(kept.route, (std::vector<std::string>{"panel", "field"}));
  EXPECT_EQ(kept.from, "panel");
  EXPECT_EQ(kept.to, "field");
  ASSERT_EQ(kept.checks.size(), 9U);
  EXPECT_EQ(kept.checks[8].where, "end to end");
  EXPECT_EQ(kept.checks[8].attribute, "MaxPayload");
  EXPECT_EQ(kept.checks[7].where, "capacity of field");
  EXPECT_EQ(kept.checks[8].margin, "12.5 ms to spare");
  EXPECT_EQ(kept.checks[0].margin, "1 to spare");
  EXPECT_TRUE(kept.checks[8].fits);
  EXPECT_EQ(kept.checks[0].provided, 1U);
  EXPECT_EQ(kept.checks[8].unit, "bytes");
  EXPECT_EQ(kept.checks[0].unit, "events");
  EXPECT_EQ(kept.checks[0].attribute, "Omission");
  EXPECT_EQ(kept.checks[0].where, "bridge");
}

}  // namespace
}  // namespace mlcca::client
