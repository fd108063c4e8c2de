// SPDX-License-Identifier: BSD-2-Clause
// What mlccad and mlcca-sources say to each other arrives as it was sent, and nothing else does.
#include <gtest/gtest.h>

#include "core/mesh/bounds.hpp"
#include "core/mesh/link_table.hpp"
#include "daemon/net/sources/facts.hpp"
#include "tests/tools/sources/proto_loop.hpp"

namespace mlcca::net::facts {
namespace {

using core::mesh::Snapshot;

Snapshot snapshot(std::size_t links) {
  Snapshot out;
  for (std::size_t i = 0; i < links; ++i) {
    core::mesh::Sample s;
    s.from = std::string(core::mesh::kMaxAddress, 'a');
    s.to = "b" + std::to_string(i);
    s.rate = i;
    s.kind = core::mesh::RateKind::derived;
    if (i % 2 == 0) s.loss = i;
    if (i % 3 == 0) s.channel = 2412;
    if (i % 5 == 0) s.busy = 7;
    if (i % 7 == 0) s.weight = 0xffff'ffff'ffff;
    s.taken = ~std::uint64_t{0} - i;
    if (i % 11 == 0) s.valid = i;
    out.links.push_back(std::move(s));
    out.next_hops.push_back({.from = "a", .to = "b", .via = "c"});
  }
  out.problem = "some";
  return out;
}

/// What a reader makes of the messages; nothing if it refuses one or misses the end.
std::optional<Snapshot> read_back(const std::vector<Message>& messages) {
  AnswerReader reader;
  for (const auto& message : messages) {
    EXPECT_LE(message.size(), kMaxMessage);
    auto read = reader.take(message);
    if (!read) return std::nullopt;
    if (*read) return *read;
  }
  return std::nullopt;
}

TEST(Facts, ASnapshotArrivesAsItWasSent) {
  for (const std::size_t links : {0U, 1U, 500U})
    EXPECT_EQ(read_back(answer(snapshot(links))), snapshot(links));
  EXPECT_EQ(read_back(answer(snapshot(core::mesh::kMaxFacts))), snapshot(core::mesh::kMaxFacts));
}

TEST(Facts, AnotherSnapshotStartsAgain) {
  AnswerReader reader;
  for (int i = 0; i < 2; ++i)
    for (const auto& message : answer(snapshot(3))) {
      const auto read = reader.take(message);
      ASSERT_TRUE(read);
      if (*read) {
        EXPECT_EQ(**read, snapshot(3));
      }
    }
}

TEST(Facts, MoreThanTheBoundsAreNotCollected) {
  EXPECT_EQ(read_back(answer(snapshot(core::mesh::kMaxFacts + 1))), std::nullopt);
}

TEST(Facts, AMessageThatIsCutOffOrTooLongIsRefused) {
  for (const auto& message : answer(snapshot(4))) {
    for (std::size_t size = 0; size < message.size(); ++size)
      EXPECT_FALSE(AnswerReader().take(Octets(message).first(size))) << size;
    EXPECT_FALSE(AnswerReader().take(message + "x"));
  }
}

TEST(Facts, AWordThatIsNoneIsRefused) {
  auto messages = answer(snapshot(1));
  auto& links = messages.front();
  links[0] = 1;  // nodes: only mlccad sends them
  EXPECT_FALSE(AnswerReader().take(links));
  links[0] = 3;
  const std::size_t kind = 3 + 2 + core::mesh::kMaxAddress + 2 + 2 + 8;
  ASSERT_EQ(links[kind], 2);
  links[kind] = 3;
  EXPECT_FALSE(AnswerReader().take(links));
}

TEST(Facts, AQuestionArrivesAsItWasSent) {
  std::vector<std::string> addresses;
  for (std::size_t i = 0; i < core::mesh::kMaxNodes; ++i)
    addresses.push_back("fe80::" + std::to_string(i));
  const auto mesh = test::mesh_of(addresses);
  core::mesh::Source source;
  source.kind = core::mesh::SourceKind::awds;
  source.metric = core::mesh::AwdsMetric::packet_pair;
  source.interface = "mesh0";
  source.endpoint = "/run/socket";
  QuestionReader reader;
  std::optional<Question> got;
  for (const auto& message : question(source, mesh)) {
    ASSERT_LE(message.size(), kMaxMessage);
    const auto read = reader.take(message);
    ASSERT_TRUE(read) << read.error().text;
    got = *read;
  }
  ASSERT_TRUE(got);
  EXPECT_EQ(got->source, source);
  EXPECT_EQ(got->mesh.nodes, mesh.nodes);
}

}  // namespace
}  // namespace mlcca::net::facts
