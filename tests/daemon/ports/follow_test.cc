// SPDX-License-Identifier: BSD-2-Clause
// A notification of an interface that is no port's changes nothing; whatever may be a port's is
// followed.
#include <gtest/gtest.h>
#include <poll.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "daemon/net/pair.hpp"
#include "daemon/ports/ports.hpp"
#include "tests/daemon/gates/sandbox.hpp"

namespace mlcca {
namespace {

void shell(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(*-command-processor)
}

class FollowTest : public ::testing::Test {
 protected:
  FollowTest() {
    const auto paired = net::make_pair("veth", {"eth7", kNear}, {"far7", kFar});
    EXPECT_TRUE(paired) << paired.error().text;
    links_.emplace(net::Links::open().value());
    ports_.emplace(
        *links_, control_, [this](int ifindex) { return facts_[ifindex]; },
        [](const std::string&, const std::string&, bool) {}, [](Kind, const std::string&, bool) {});
  }
  ~FollowTest() override {
    for (const char* name : {"eth7", "eth8", "other", "late"})
      // NOLINTNEXTLINE(*-command-processor): in a namespace of its own
      static_cast<void>(std::system(("ip link del " + std::string(name) + " 2>/dev/null").c_str()));
  }

  void describe(const core::InterfaceIdentity& identity) {
    core::System system;
    system.networks.resize(1);
    system.networks[0].name = "lan";
    system.networks[0].kind = core::NetworkKind::udp_multicast;
    system.networks[0].profile = core::Profile::famouso;
    system.gateways.resize(1);
    system.gateways[0].ports.resize(1);
    system.gateways[0].ports[0].identity = identity;
    ports_->describe(system, 0);
    follow();
  }
  void describe_by_name() {
    core::InterfaceIdentity identity;
    identity.name = "eth7";
    describe(identity);
    ASSERT_NE(ports_->gate(0), nullptr) << ports_->problem(0);
  }
  void follow() {
    ASSERT_TRUE(links_->refresh());
    ports_->follow();
    EXPECT_FALSE(needs_reconcile()) << "it has been followed";
  }
  bool needs_reconcile() {
    EXPECT_TRUE(links_->refresh());
    return ports_->needs_reconcile();
  }

  /// Follows what the kernel reports until the port has this problem.
  void expect_problem(const std::string& problem) {
    for (int n = 0; n < 100 && ports_->problem(0) != problem; ++n) {
      pollfd notices{.fd = links_->fd(), .events = POLLIN, .revents = 0};
      ::poll(&notices, 1, 100);
      ASSERT_TRUE(links_->refresh());
      ports_->follow();
    }
    EXPECT_EQ(ports_->problem(0), problem);
  }

  static constexpr int kNear = 4711;
  static constexpr int kFar = 4712;
  std::string root_ = test::new_bpf_root();
  gates::Control control_ = gates::Control::create(root_).value();
  std::map<int, net::UdevFacts> facts_;
  std::optional<net::Links> links_;
  std::optional<Ports> ports_;
};

TEST_F(FollowTest, AnInterfaceThatIsNotDescribedIsNotFollowed) {
  describe_by_name();
  for (const char* command :
       {"ip link add other type veth peer name eth8", "ip link set other up", "ip link set eth8 up",
        "ip link set eth8 down", "ip link set eth8 name late", "ip link set late alias eth7",
        "ip link set far7 up", "ip link del other"}) {
    shell(command);
    EXPECT_FALSE(needs_reconcile()) << command;
  }
}

TEST_F(FollowTest, WhateverBecomesOfAPortIsFollowed) {
  describe_by_name();
  for (const char* command :
       {"ip link set eth7 down", "ip link set eth7 alias a", "ip link set eth7 up",
        "ip link set eth7 name late", "ip link set late name eth7", "ip link del eth7",
        "ip link add eth7 type veth peer name far7"}) {
    shell(command);
    EXPECT_TRUE(needs_reconcile()) << command;
    EXPECT_TRUE(needs_reconcile()) << "until it is followed: " << command;
    follow();
  }
}

/// The kernel reports a carrier up to a second later.
TEST_F(FollowTest, ACarrierThatComesAndGoesIsFollowed) {
  constexpr const char* unplugged =
      "eth7 has no carrier: its cable is unplugged, or nobody is at the other end";
  describe_by_name();
  shell("ip link set eth7 up; ip link set far7 down");
  expect_problem(unplugged);
  shell("ip link set far7 up");
  expect_problem("");
  shell("ip link set far7 down");
  expect_problem(unplugged);
}

TEST_F(FollowTest, AnotherInterfaceThatGetsThePortsNameIsFollowed) {
  describe_by_name();
  shell("ip link set eth7 name late");
  follow();
  EXPECT_FALSE(ports_->problem(0).empty());
  shell("ip link add other type veth peer name eth8");
  EXPECT_FALSE(needs_reconcile());
  shell("ip link set eth8 name eth7");
  EXPECT_TRUE(needs_reconcile());
  follow();
  EXPECT_NE(ports_->gate(0), nullptr);
}

TEST_F(FollowTest, AnotherInterfaceWithTheSameNumberAndNameIsFollowed) {
  describe_by_name();
  shell("ip link del eth7");
  shell("ip link add eth7 index 4711 type veth peer name far7");
  EXPECT_TRUE(needs_reconcile());
}

TEST_F(FollowTest, AnInterfaceThatIsMovedAwayAndBackIsFollowed) {
  describe_by_name();
  shell("ip netns add follow && ip link set eth7 netns follow");
  EXPECT_TRUE(needs_reconcile());
  shell("ip -n follow link set eth7 netns $$ && ip netns del follow");
  EXPECT_TRUE(needs_reconcile());
}

TEST_F(FollowTest, WhatWasGatedAndIsNotDescribedAnyMoreIsFollowedWhenItGoes) {
  describe_by_name();
  core::InterfaceIdentity identity;
  identity.name = "eth8";
  describe(identity);
  shell("ip link del eth7");
  EXPECT_TRUE(needs_reconcile());
  follow();
}

TEST_F(FollowTest, WhileTwoMatchEveryNewsIsFollowed) {
  shell("ip link set eth7 alias mine");
  core::InterfaceIdentity identity;
  identity.alias = "mine";
  describe(identity);
  ASSERT_NE(ports_->gate(0), nullptr) << ports_->problem(0);
  shell("ip link add other type veth peer name eth8");
  EXPECT_FALSE(needs_reconcile());
  shell("ip link set eth8 alias mine");
  EXPECT_TRUE(needs_reconcile());
  ASSERT_TRUE(links_->refresh());
  ports_->follow();
  EXPECT_TRUE(needs_reconcile());
  shell("ip link del other");
  EXPECT_TRUE(needs_reconcile());
  follow();
  EXPECT_NE(ports_->gate(0), nullptr) << ports_->problem(0);
}

TEST_F(FollowTest, WhatUdevLearnsOfAnInterfaceIsFollowedWhereAPortIsRecognisedByIt) {
  core::InterfaceIdentity identity;
  identity.serial = "0042";
  describe(identity);
  facts_[kFar].serial = "0043";
  EXPECT_FALSE(needs_reconcile());
  facts_[kNear].serial = "0042";
  EXPECT_TRUE(needs_reconcile());
  follow();
  ASSERT_NE(ports_->gate(0), nullptr) << ports_->problem(0);
  facts_[kFar].serial = "0042";
  EXPECT_TRUE(needs_reconcile()) << "two of them";
  facts_[kFar].serial = "";
  facts_[kNear].serial = "";
  EXPECT_TRUE(needs_reconcile()) << "it is no port's any more";
}

}  // namespace
}  // namespace mlcca
