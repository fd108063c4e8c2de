// SPDX-License-Identifier: BSD-2-Clause
// What a description says of the links of a mesh, in a whole gateway among fakes.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr Value kMbit = 1'000'000;

/// c0 goes from the first bus over the gateway and a link of a mesh, whose rate is described.
core::System over_a_mesh(Value rate) {
  core::System system = small_system();
  const std::size_t last = system.networks.size() - 1;
  core::Network& mesh = system.networks[last];
  mesh.name = "mesh";
  mesh.kind = core::NetworkKind::mesh;
  mesh.provision = {};
  mesh.mesh.emplace();
  mesh.mesh->per_hop = AttributeSet{}
                           .set(Attribute::latency, kMs)
                           .set(Attribute::jitter, kMs)
                           .set(Attribute::omission, 0);
  mesh.mesh->nodes = {{.name = "here", .address = {}, .gateway = 0, .origin = {}},
                      {.name = "there", .address = {}, .gateway = {}, .origin = {}}};
  for (std::uint32_t from = 0; from < 2; ++from) {
    core::mesh::DescribedLink& link = mesh.mesh->links.emplace_back();
    link.from = from;
    link.to = 1 - from;
    link.rate = rate;
  }
  mesh.mesh->sources.resize(1);  // of the kind `description`
  system.gateways[0].ports[last].identity.name = mesh.name;
  core::Subscriber& subscriber = system.subscribers[0];
  subscriber.place = {core::Place::Kind::network, last};
  subscriber.mesh_node = 1;
  return system;
}

class DescribedLinks : public ::testing::Test {
 protected:
  explicit DescribedLinks(Value rate) : bench_(over_a_mesh(rate)) {}
  void start() {
    ASSERT_FALSE(bench_.start());
    bench_.act();
  }
  void reload_with(Value rate) {
    bench_.events.clear();
    bench_.system = over_a_mesh(rate);
    static_cast<void>(bench_.ask(control::ReloadRequest{}));
    bench_.reading().finish();
    bench_.act();
  }
  [[nodiscard]] bool is_event(const std::string& kind) const {
    return std::ranges::find(bench_.events, kind) != bench_.events.end();
  }
  Bench bench_;
};

class FastLinks : public DescribedLinks {
 protected:
  FastLinks() : DescribedLinks(54 * kMbit) {}
};
class SlowLinks : public DescribedLinks {
 protected:
  SlowLinks() : DescribedLinks(kMbit / 1000) {}
};

TEST_F(FastLinks, AreKnownWhenAStartDecides) {
  start();
  EXPECT_EQ(bench_.state().granted(), 1U);
  EXPECT_FALSE(is_event("refused"));
}

TEST_F(FastLinks, AreKnownWhenAReloadDecides) {
  start();
  reload_with(12 * kMbit);
  EXPECT_EQ(bench_.state().granted(), 1U);
  EXPECT_FALSE(is_event("refused"));
  EXPECT_FALSE(is_event("withdrawn"));
}

/// What lasts is asked of what is measured; this is stated.
TEST_F(SlowLinks, AreAsFastAsTheNewDescriptionSaysAtOnce) {
  start();
  ASSERT_EQ(bench_.state().granted(), 0U);
  reload_with(54 * kMbit);
  EXPECT_EQ(bench_.state().granted(), 1U);
}

TEST_F(FastLinks, AreAsSlowAsTheNewDescriptionSaysAtOnce) {
  start();
  reload_with(kMbit / 1000);
  EXPECT_EQ(bench_.state().granted(), 0U);
}

}  // namespace
}  // namespace mlcca::test
