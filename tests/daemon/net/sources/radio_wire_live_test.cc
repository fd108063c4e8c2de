// SPDX-License-Identifier: BSD-2-Clause
// The source wire on a veth pair in a network namespace of its own (root).
#include <gtest/gtest.h>
#include <sched.h>

#include <cstdlib>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "daemon/net/sources/wire.hpp"

namespace mlcca::net {
namespace {

constexpr const char* kOwn = "02:00:00:00:00:0a";
constexpr const char* kPeer = "02:00:00:00:00:0b";
constexpr std::uint64_t kPatience = 10'000'000;  // µs without a snapshot

void run(const std::string& command) { ASSERT_EQ(std::system(command.c_str()), 0) << command; }

/// Enters a network namespace once for all tests of this program; each test has its own interfaces.
bool enter_namespace() {
  static const bool entered = unshare(CLONE_NEWNET) == 0;
  return entered;
}

class WireLive : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(enter_namespace()) << "needs root";
    sd_event* raw = nullptr;
    ASSERT_GE(sd_event_new(&raw), 0);
    loop_.reset(raw);
    core::mesh::Mesh mesh;
    for (const char* address : {kOwn, kPeer}) {
      core::mesh::Node node;
      node.address = address;
      mesh.nodes.push_back(node);
    }
    core::mesh::Source described;
    described.kind = core::mesh::SourceKind::wire;
    described.interface = "wire0";
    auto opened = open_wire(described, mesh, loop_.get(), [this](core::mesh::Snapshot snapshot) {
      snapshots_.push_back(std::move(snapshot));
    });
    ASSERT_TRUE(opened) << opened.error().text;
    source_ = std::move(*opened);
  }
  void TearDown() override {
    source_.reset();
    static_cast<void>(std::system("ip link del wire0 2>/dev/null"));
  }

  /// Turns the loop until one of the next twenty snapshots is so: they come each second at least.
  void await(const std::function<bool(const core::mesh::Snapshot&)>& is_so) {
    for (int seen = 0; seen < 20; ++seen) {
      while (snapshots_.empty())
        ASSERT_GT(sd_event_run(loop_.get(), kPatience), 0) << "nothing is reported";
      last_ = std::move(snapshots_.front());
      snapshots_.pop_front();
      if (is_so(last_)) return;
    }
    FAIL() << "never reported; last: " << last_.links.size() << " links, problem \""
           << last_.problem << '"';
  }
  void await_problem(const std::string& text) {
    await([&](const core::mesh::Snapshot& s) { return s.problem == text && s.links.empty(); });
  }
  void await_links(std::size_t count) {
    await([&](const core::mesh::Snapshot& s) {
      return s.problem.empty() && s.links.size() == count;
    });
  }

  core::mesh::Snapshot last_;

 private:
  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
  std::deque<core::mesh::Snapshot> snapshots_;
  std::unique_ptr<LinkSource> source_;
};

TEST_F(WireLive, ReportsTheSpeedWhileThereIsACarrier) {
  await_problem("there is no interface wire0");
  run(std::string("ip link add wire0 address ") + kOwn + " type veth peer name wire1");
  run("ip link set wire0 up");
  await_links(0);
  run("ip link set wire1 up");
  await_links(2);
  for (const auto& link : last_.links) {
    EXPECT_EQ(link.rate, 10'000'000'000U) << "what the kernel says of a veth pair";
    EXPECT_EQ(link.kind, core::mesh::RateKind::phy);
    EXPECT_GT(link.taken, 0U);
  }
  ASSERT_EQ(last_.links.size(), 2U);
  EXPECT_EQ(last_.links[0].from, kOwn);
  EXPECT_EQ(last_.links[0].to, kPeer);
  EXPECT_EQ(last_.links[1].from, kPeer);
  EXPECT_EQ(last_.links[1].to, kOwn);
  run("ip link set wire1 down");
  await_links(0);
  run("ip link set wire1 up");
  await_links(2);
  run("ip link del wire0");
  await_problem("there is no interface wire0");
}

TEST_F(WireLive, AnInterfaceThatIsRenamedIsGone) {
  run(std::string("ip link add wire0 address ") + kOwn + " type veth peer name wire1");
  run("ip link set wire0 up");
  run("ip link set wire1 up");
  await_links(2);
  run("ip link set wire0 down");
  run("ip link set wire0 name wire2");
  await_problem("there is no interface wire0");
  run("ip link del wire2");
}

TEST(WireOpen, WithoutAnInterfaceIsAnError) { EXPECT_FALSE(open_wire({}, {}, nullptr, {})); }

}  // namespace
}  // namespace mlcca::net
