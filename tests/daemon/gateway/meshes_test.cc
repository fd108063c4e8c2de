// SPDX-License-Identifier: BSD-2-Clause
// What is known of the links of a mesh stays known when its list of sources changes.
#include "daemon/gateway/meshes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "base/clock.hpp"

namespace mlcca {
namespace {

using core::mesh::SourceKind;

constexpr std::uint32_t kA = 0;
constexpr std::uint32_t kB = 1;

class MeshesOfSources : public ::testing::Test {
 protected:
  /// Opened sources, by endpoint: they report what the test says.
  using Open = std::map<std::string, net::LinkSource::Report>;

  static core::mesh::Source file(const std::string& endpoint) {
    core::mesh::Source source;
    source.kind = SourceKind::file;
    source.endpoint = endpoint;
    return source;
  }
  void describe(std::vector<core::mesh::Source> sources) {
    core::System system;
    core::Network& network = system.networks.emplace_back();
    network.name = "mesh";
    network.kind = core::NetworkKind::mesh;
    network.mesh.emplace();
    network.mesh->nodes = {{.name = "a", .address = {}, .gateway = 0, .origin = {}},
                           {.name = "b", .address = {}, .gateway = {}, .origin = {}}};
    network.mesh->sources = std::move(sources);
    open_.clear();
    meshes_.describe(system, 0);
  }
  void say(const std::string& endpoint, const std::string& from, const std::string& to,
           Value rate) {
    core::mesh::Snapshot snapshot;
    core::mesh::Sample& sample = snapshot.links.emplace_back();
    sample.from = from;
    sample.to = to;
    sample.rate = rate;
    sample.taken = monotonic_ns();
    open_.at(endpoint)(snapshot);
  }
  /// bit/s; 0: the link carries nothing.
  [[nodiscard]] Value rate(std::uint32_t from, std::uint32_t to) const {
    const core::mesh::Link* link = meshes_.table(0)->graph().find(from, to);
    return link == nullptr ? 0 : link->quality.rate;
  }

  Open open_;
  Meshes meshes_{nullptr, [](std::size_t) {}, [](const std::string&, const std::string&, bool) {},
                 [this](const core::mesh::Source& source, const core::mesh::Mesh&, sd_event*,
                        net::LinkSource::Report to) -> Result<std::unique_ptr<net::LinkSource>> {
                   open_[source.endpoint] = std::move(to);
                   return std::make_unique<net::LinkSource>();
                 }};
};

TEST_F(MeshesOfSources, KeepWhatOneSaidWhenAnotherIsAdded) {
  describe({file("knows")});
  say("knows", "a", "b", 54);
  ASSERT_EQ(rate(kA, kB), 54U);
  describe({file("knows"), file("more")});
  EXPECT_EQ(rate(kA, kB), 54U);
}

TEST_F(MeshesOfSources, KeepWhatOneSaidWhenAnotherBeforeItIsRemoved) {
  describe({file("other"), file("knows")});
  say("knows", "a", "b", 54);
  describe({file("knows")});
  EXPECT_EQ(rate(kA, kB), 54U);
  open_.at("knows")({});
  EXPECT_EQ(rate(kA, kB), 0U) << "it is this source that has said so";
}

TEST_F(MeshesOfSources, ForgetWhatARemovedOneAloneKnew) {
  describe({file("knows"), file("removed")});
  say("knows", "a", "b", 54);
  say("removed", "b", "a", 12);
  ASSERT_EQ(rate(kB, kA), 12U);
  describe({file("knows")});
  EXPECT_EQ(rate(kA, kB), 54U);
  EXPECT_EQ(rate(kB, kA), 0U);
}

TEST_F(MeshesOfSources, DoNotTakeAnotherForTheOneThatKnew) {
  describe({file("knows")});
  say("knows", "a", "b", 54);
  describe({file("elsewhere")});
  EXPECT_EQ(rate(kA, kB), 0U);
}

TEST_F(MeshesOfSources, GoWithTheSourceAndNotWithItsPlaceInTheList) {
  describe({file("first"), file("second")});
  say("first", "a", "b", 54);
  say("second", "b", "a", 12);
  describe({file("second"), file("first")});
  open_.at("second")({});
  EXPECT_EQ(rate(kA, kB), 54U);
  EXPECT_EQ(rate(kB, kA), 0U);
}

}  // namespace
}  // namespace mlcca
