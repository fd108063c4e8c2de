// SPDX-License-Identifier: BSD-2-Clause
// Which interface a port is, and why it cannot be used, by what is listed.
#include "daemon/ports/described_port.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/daemon/ports/fake_gates.hpp"

namespace mlcca {
namespace {

class DescribedPortTest : public ::testing::Test {
 protected:
  DescribedPortTest() {
    system_.networks.resize(1);
    system_.networks[0].name = "bus";
    system_.networks[0].kind = core::NetworkKind::can;
    system_.networks[0].profile = core::Profile::famouso;
    system_.gateways.resize(1);
    system_.gateways[0].ports.resize(1);
    system_.gateways[0].ports[0].identity.name = "can0";
    list(7);
  }
  void list(int ifindex) {
    links_.clear();
    net::Link link;
    link.ifindex = ifindex;
    link.name = "can0";
    link.kind = "can";
    link.is_can = true;
    link.up = link.running = true;
    link.bitrate = 500'000;
    links_.emplace(ifindex, link);
  }
  net::Link& link() { return links_.begin()->second; }
  std::optional<int> match() { return port().match(links_, facts_of_); }
  void assess() { port().assess(links_, report_); }
  [[nodiscard]] bool is_outdated() { return port().is_outdated(links_, facts_of_); }
  DescribedPort& port() {
    if (!made_) made_.emplace(system_, system_.gateways[0].ports[0]);
    return *made_;
  }

  core::System system_;
  net::InterfaceTable links_;
  net::FactsOf facts_of_ = [](int) { return net::UdevFacts{}; };
  std::vector<std::string> reported_;
  ReportLine report_ = [this](const std::string&, const std::string& line, bool) {
    reported_.push_back(line);
  };
  std::optional<DescribedPort> made_;
};

TEST_F(DescribedPortTest, SaysWhichInterfaceItWasWhereThatIsAnotherOne) {
  EXPECT_EQ(match(), 0) << "it was none";
  EXPECT_EQ(match(), std::nullopt) << "it is the same";
  list(8);
  EXPECT_EQ(match(), 7);
  EXPECT_EQ(port().ifindex(), 8);
  links_.clear();
  EXPECT_EQ(match(), 8);
  EXPECT_EQ(port().problem(), "the interface (name can0) is absent");
}

TEST_F(DescribedPortTest, TwoInterfacesThatMatchAreNone) {
  system_.gateways[0].ports[0].identity = {};
  system_.gateways[0].ports[0].identity.alias = "mine";
  link().alias = "mine";
  match();
  EXPECT_EQ(port().ifindex(), 7);
  net::Link other = link();
  other.ifindex = 8;
  links_.emplace(8, other);
  EXPECT_EQ(match(), 7);
  EXPECT_EQ(port().ifindex(), 0);
  EXPECT_NE(port().problem().find("name the interface more closely"), std::string::npos);
}

TEST_F(DescribedPortTest, HasAGateForInterfacesOfItsKindAlone) {
  net::Link can = link();
  net::Link ethernet;
  ethernet.name = "eth0";
  ethernet.is_ethernet = true;
  net::Link wpan;
  wpan.name = "wpan0";
  wpan.is_wpan = true;
  const std::vector<std::pair<core::NetworkKind, const net::Link*>> rows = {
      {core::NetworkKind::can, &can},
      {core::NetworkKind::udp_multicast, &ethernet},
      {core::NetworkKind::mesh, &ethernet},
      {core::NetworkKind::ieee802154, &wpan}};
  for (const auto& [kind, fits] : rows) {
    system_.networks[0].kind = kind;
    const DescribedPort port(system_, system_.gateways[0].ports[0]);
    for (const net::Link* one : {&can, &ethernet, &wpan})
      EXPECT_EQ(port.can_have_gate(*one), one == fits) << one->name;
    if (kind == core::NetworkKind::ieee802154) {
      EXPECT_EQ(port.lacks_framing(ethernet), "eth0 is not an interface of IEEE 802.15.4");
    }
  }
}

TEST_F(DescribedPortTest, CannotBeUsedWhileItsInterfaceIsDownOrHasNoBitRate) {
  const auto problem = [&] {
    match();
    assess();
    return port().problem();
  };
  EXPECT_EQ(problem(), "");
  link().up = link().running = false;
  EXPECT_EQ(problem(), "can0 is down");
  link().up = true;
  link().can_state = "bus-off";
  EXPECT_EQ(problem(), "can0 is bus-off");
  link().can_state = "error-active";
  EXPECT_EQ(problem(),
            "can0 has no carrier: its cable is unplugged, or nobody is at the other end");
  link().running = true;
  link().bitrate = 0;
  EXPECT_EQ(problem(), "the bit rate of can0 is unknown");
}

TEST_F(DescribedPortTest, AVirtualBusNeedsTheBitRateOfItsNetwork) {
  link().kind = "vcan";
  link().bitrate = 0;
  match();
  assess();
  EXPECT_EQ(port().problem(), "can0 has no bit rate of its own: state <Bus bitrate=\"…\"/> of bus");
  system_.networks[0].bus.bitrate = 500'000;
  made_.reset();
  match();
  assess();
  EXPECT_EQ(port().problem(), "");
}

TEST_F(DescribedPortTest, ADisturbedBusIsReportedWhenItBeginsAndWhenItEnds) {
  link().can_state = "error-passive";
  for (int n = 0; n < 2; ++n) match(), assess();
  EXPECT_EQ(reported_,
            std::vector<std::string>{"can0 is error-passive: frames on bus are being disturbed"});
  link().can_state = "error-active";
  for (int n = 0; n < 2; ++n) match(), assess();
  EXPECT_EQ(reported_.size(), 2U);
  EXPECT_EQ(reported_.back(), "can0 is error-active again");
}

TEST_F(DescribedPortTest, IsOutdatedByWhateverChangesOnItsInterfaceAlone) {
  match();
  EXPECT_TRUE(is_outdated()) << "it has not been settled";
  assess();
  EXPECT_FALSE(is_outdated());
  links_.emplace(9, test::ethernet(9, "eth9"));
  EXPECT_FALSE(is_outdated()) << "another interface";
  link().bitrate = 250'000;
  EXPECT_TRUE(is_outdated());
  assess();
  links_.erase(7);
  EXPECT_TRUE(is_outdated());
}

TEST_F(DescribedPortTest, DescribedAgainItIsRaisedAgainOnlyForOtherBitRates) {
  system_.gateways[0].ports[0].managed = true;
  match();
  const DescribedPort former = port();
  system_.gateways[0].ports[0].bitrate = 125'000;
  DescribedPort next(system_, system_.gateways[0].ports[0]);
  EXPECT_TRUE(next.is_same(former));
  next.take_over(former);
  EXPECT_EQ(next.ifindex(), 7);
  EXPECT_TRUE(next.is_to_be_raised());
  system_.networks[0].name = "other";
  EXPECT_FALSE(DescribedPort(system_, system_.gateways[0].ports[0]).is_same(former));
}

}  // namespace
}  // namespace mlcca
