// SPDX-License-Identifier: BSD-2-Clause
// What the relay carries, among layers that are none.
#include "relay/carrier.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace mlcca::relay {
namespace {

using control::Transfer;

/// Interfaces of a test: what was sent on each, and who follows.
struct World {
  struct Interface {
    std::map<Layer::Follower, std::uint64_t> followers;  ///< subjects
    std::vector<std::pair<std::uint64_t, std::string>> sent;
    std::vector<std::pair<std::uint64_t, std::string>> coming;
    bool there = true;
    bool usable = true;
    Sent outcome = Sent::sent;
    bool takes_followers = true;
    unsigned expired = 0;
  };
  std::map<std::uint32_t, Interface> interfaces;
  std::map<std::uint32_t, int> watched;
  std::vector<std::string> log;
  unsigned opened = 0;
  std::uint64_t now = 1'000'000;
};

class FakeLayer : public Layer {
 public:
  explicit FakeLayer(World::Interface& interface) : interface_(interface) {}
  ~FakeLayer() override { interface_.followers.clear(); }
  FakeLayer(const FakeLayer&) = delete;
  FakeLayer& operator=(const FakeLayer&) = delete;
  FakeLayer(FakeLayer&&) = delete;
  FakeLayer& operator=(FakeLayer&&) = delete;

  [[nodiscard]] int fd() const override { return 7; }
  [[nodiscard]] Result<void> follow(Follower follower, const control::Endpoint& /*endpoint*/,
                                    std::uint64_t subject, std::size_t /*longest*/) override {
    if (!interface_.takes_followers) return fail("not this profile");
    interface_.followers[follower] = subject;
    return {};
  }
  void leave(Follower follower, const control::Endpoint& /*endpoint*/,
             std::uint64_t /*subject*/) override {
    interface_.followers.erase(follower);
  }
  bool receive(std::size_t /*most*/, const OnEvent& on_event) override {
    if (!interface_.there) return false;
    for (const auto& [subject, text] : std::exchange(interface_.coming, {}))
      for (const auto& [follower, followed] : interface_.followers)
        if (followed == subject) {
          const std::vector<std::uint8_t> octets(text.begin(), text.end());
          on_event({follower, octets, 1'000'000});
        }
    return true;
  }
  Sent send(const control::Endpoint& /*endpoint*/, std::uint64_t subject, Octets event) override {
    interface_.sent.emplace_back(subject, std::string(event.begin(), event.end()));
    return interface_.outcome;
  }
  [[nodiscard]] Losses losses() const override { return {}; }
  void expire() override { ++interface_.expired; }
  [[nodiscard]] bool holds_parts() const override { return true; }

 private:
  World::Interface& interface_;
};

Transfer transfer(std::uint64_t subject, std::uint32_t from, std::uint32_t to) {
  Transfer out;
  out.subject = subject;
  out.channel = "c" + std::to_string(subject);
  out.publisher = "p";
  out.from.ifindex = from;
  out.from.interface = "if" + std::to_string(from);
  out.to.ifindex = to;
  out.to.interface = "if" + std::to_string(to);
  out.event_bytes = 100;
  out.latency_ns = 500;
  return out;
}

class CarrierTest : public ::testing::Test {
 protected:
  void come(std::uint32_t interface, std::uint64_t subject, const std::string& text) {
    world_.interfaces[interface].coming.emplace_back(subject, text);
    carrier_.receive(interface);
  }
  [[nodiscard]] std::vector<Carried> counters() const {
    std::vector<Carried> out;
    carrier_.each([&](const Transfer&, const Carried& carried) { out.push_back(carried); });
    return out;
  }
  using Sents = std::vector<std::pair<std::uint64_t, std::string>>;

  World world_;
  Carrier carrier_{
      {.open = [this](const control::Endpoint& endpoint) -> Result<std::unique_ptr<Layer>> {
         auto& interface = world_.interfaces[endpoint.ifindex];
         if (!interface.usable) return fail("no such device");
         ++world_.opened;
         return std::make_unique<FakeLayer>(interface);
       },
       .watch = [this](std::uint32_t ifindex, int fd) { world_.watched[ifindex] = fd; },
       .log = [this](const std::string& line) { world_.log.push_back(line); },
       .unix_ns = [this] { return world_.now; }}};
};

TEST_F(CarrierTest, AnEventGoesWhereItIsGrantedAndNowhereElse) {
  carrier_.set_all({transfer(1, 10, 20), transfer(1, 10, 30), transfer(2, 20, 10)});
  EXPECT_EQ(carrier_.transfers(), 3U);
  come(10, 1, "one");
  come(10, 2, "two");
  EXPECT_EQ(world_.interfaces[20].sent, (Sents{{1, "one"}}));
  EXPECT_EQ(world_.interfaces[30].sent, (Sents{{1, "one"}}));
  EXPECT_TRUE(world_.interfaces[10].sent.empty());
  come(20, 2, "two");
  EXPECT_EQ(world_.interfaces[10].sent, (Sents{{2, "two"}}));
}

TEST_F(CarrierTest, WhatIsWithdrawnIsNotCarriedAndItsInterfaceIsClosed) {
  carrier_.set_all({transfer(1, 10, 20), transfer(2, 10, 30)});
  carrier_.set(1, {});
  come(10, 1, "one");
  EXPECT_TRUE(world_.interfaces[20].sent.empty());
  EXPECT_EQ(world_.watched[20], -1);
  EXPECT_EQ(world_.watched[10], 7);
  carrier_.set_all({});
  EXPECT_EQ(carrier_.interfaces(), 0U);
  EXPECT_EQ(carrier_.transfers(), 0U);
}

TEST_F(CarrierTest, WhatStaysKeepsItsCounters) {
  carrier_.set_all({transfer(1, 10, 20), transfer(2, 10, 20)});
  come(10, 1, "one");
  world_.interfaces[20].outcome = Sent::dropped;
  world_.now += 600;
  come(10, 1, "late");
  carrier_.set_all({transfer(3, 10, 20), transfer(1, 10, 20)});
  bool found = false;
  carrier_.each([&](const Transfer& t, const Carried& carried) {
    if (t.subject != 1) return;
    found = true;
    EXPECT_EQ(carried.events, 2U);
    EXPECT_EQ(carried.dropped, 1U);
    EXPECT_EQ(carried.late, 1U) << "the gateway promises 500 ns";
    EXPECT_EQ(carried.longest_ns, 600U);
  });
  EXPECT_TRUE(found);
  EXPECT_EQ(counters().size(), 2U);
}

TEST_F(CarrierTest, WhatWasLateIsTakenOnceInAPause) {
  carrier_.set_all({transfer(1, 10, 20), transfer(2, 10, 20)});
  std::vector<std::string> taken;
  const auto take = [&](std::uint64_t now) {
    taken.clear();
    carrier_.take_delays(now, 100, [&](const Transfer& t, const Delay& delay) {
      taken.push_back(t.channel + ": " + std::to_string(delay.late) + ", " +
                      std::to_string(delay.longest_ns));
    });
    return taken;
  };
  come(10, 1, "in time");
  EXPECT_TRUE(take(1000).empty());
  world_.now += 700;
  come(10, 1, "late");
  world_.now -= 100;
  come(10, 1, "late");
  EXPECT_EQ(take(1000), std::vector<std::string>{"c1: 2, 700"});
  EXPECT_TRUE(take(1200).empty()) << "nothing was late since then";
  come(10, 1, "late");
  EXPECT_EQ(take(1200), std::vector<std::string>{"c1: 1, 600"});
  come(10, 1, "late");
  come(10, 2, "late");
  EXPECT_EQ(take(1299), std::vector<std::string>{"c2: 1, 600"});
  EXPECT_EQ(take(1300), std::vector<std::string>{"c1: 1, 600"});
}

TEST_F(CarrierTest, WhatIsBegunIsGivenUpOnAllInterfaces) {
  carrier_.set_all({transfer(1, 1, 2)});
  carrier_.expire();
  EXPECT_EQ(world_.interfaces[1].expired, 1U);
  EXPECT_EQ(world_.interfaces[2].expired, 1U);
}

TEST_F(CarrierTest, NothingGoesBackToWhereItCameFrom) {
  carrier_.set_all({transfer(1, 10, 10)});
  EXPECT_EQ(carrier_.transfers(), 0U);
}

TEST_F(CarrierTest, AnInterfaceThatIsGoneTakesItsTransfersAlong) {
  carrier_.set_all({transfer(1, 10, 20), transfer(2, 20, 30)});
  world_.interfaces[10].there = false;
  carrier_.receive(10);
  EXPECT_EQ(carrier_.transfers(), 1U);
  EXPECT_EQ(world_.watched[10], -1);
  come(20, 2, "goes on");
  EXPECT_EQ(world_.interfaces[30].sent.size(), 1U);
  world_.interfaces[10].there = true;
  carrier_.set_all({transfer(1, 10, 20), transfer(2, 20, 30)});
  come(10, 1, "again");
  EXPECT_EQ(world_.interfaces[20].sent, (Sents{{1, "again"}}));
}

TEST_F(CarrierTest, WhatCannotBeCarriedIsReportedAndHindersNothing) {
  world_.interfaces[30].usable = false;
  world_.interfaces[40].takes_followers = false;
  carrier_.set_all({transfer(1, 10, 30), transfer(2, 40, 20), transfer(3, 10, 20)});
  EXPECT_EQ(carrier_.transfers(), 1U);
  std::ranges::sort(world_.log);
  EXPECT_EQ(world_.log,
            (std::vector<std::string>{"c2 is not carried from if40 to if20: not this profile",
                                      "if30 cannot be used: no such device"}));
  come(10, 3, "goes");
  EXPECT_EQ(world_.interfaces[20].sent.size(), 1U);
}

/// A network of another kind on the same interface, after a reload.
TEST_F(CarrierTest, AnInterfaceIsOpenedAgainWhereItsNetworkHasAnotherForm) {
  std::vector<Transfer> all{transfer(1, 10, 20), transfer(2, 10, 20), transfer(3, 30, 10)};
  carrier_.set_all(all);
  const unsigned before = world_.opened;
  for (Transfer& one : all) {
    if (one.to.ifindex == 20) one.to.broadcast = true;
    one.from.id = 7;  // is of the channel alone
  }
  carrier_.set_all(all);
  EXPECT_EQ(world_.opened, before + 1);
  EXPECT_EQ(carrier_.transfers(), 3U);
  EXPECT_EQ(world_.watched[20], 7);
  come(10, 1, "one");
  come(10, 2, "two");
  EXPECT_EQ(world_.interfaces[20].sent, (Sents{{1, "one"}, {2, "two"}}));
  // Each by itself, as after events of channels: the first one opens it, and the daemon is asked
  // for the others.
  all[1].to.broadcast = false;
  carrier_.set(2, {all[1]});
  come(10, 2, "two");
  EXPECT_EQ(world_.interfaces[20].sent.back().second, "two");
  EXPECT_EQ(carrier_.transfers(), 2U);
  all[0].to.broadcast = false;
  carrier_.set_all(all);
  EXPECT_EQ(carrier_.transfers(), 3U);
}

TEST(FormOfLayer, IsEachFieldThatIsNotOfAChannelAlone) {
  const auto differs = [](auto change) {
    control::Endpoint other;
    change(other);
    return form_of_layer(other) != form_of_layer({});
  };
  using Endpoint = control::Endpoint;
  EXPECT_TRUE(differs([](Endpoint& e) { e.can = true; }));
  EXPECT_TRUE(differs([](Endpoint& e) { e.wpan = true; }));
  EXPECT_TRUE(differs([](Endpoint& e) { e.broadcast = true; }));
  EXPECT_TRUE(differs([](Endpoint& e) { e.profile = "j1939"; }));
  EXPECT_TRUE(differs([](Endpoint& e) { e.interface = "can1"; }));
  EXPECT_TRUE(differs([](Endpoint& e) { e.ifindex = 7; }));
  EXPECT_FALSE(differs([](Endpoint& e) {
    e.id = e.mask = e.frame_bytes = 7;
    e.classic = e.fd = e.fragmented = true;
    e.network = e.address = "other";
  }));
}

/// Another program may hold the port for a while.
TEST_F(CarrierTest, WhatCouldNotBeCarriedIsTriedAgain) {
  world_.interfaces[30].usable = false;
  carrier_.set_all({transfer(1, 10, 30), transfer(2, 10, 20)});
  carrier_.retry();
  carrier_.retry();
  EXPECT_EQ(carrier_.transfers(), 1U);
  EXPECT_EQ(world_.log, (std::vector<std::string>{"if30 cannot be used: no such device"}))
      << "once";
  world_.interfaces[30].usable = true;
  carrier_.retry();
  EXPECT_EQ(carrier_.transfers(), 2U);
  EXPECT_EQ(world_.log.back(), "if30 can be used again");
  come(10, 1, "goes");
  EXPECT_EQ(world_.interfaces[30].sent.size(), 1U);
  carrier_.retry();
  EXPECT_EQ(carrier_.transfers(), 2U);
}

TEST_F(CarrierTest, WhatIsNotGrantedAnyMoreIsNotTriedAgain) {
  world_.interfaces[30].usable = false;
  carrier_.set_all({transfer(1, 10, 30), transfer(2, 10, 30)});
  carrier_.set(1, {});
  world_.interfaces[30].usable = true;
  carrier_.retry();
  EXPECT_EQ(carrier_.transfers(), 1U);
  carrier_.set_all({});
  carrier_.retry();
  EXPECT_EQ(carrier_.transfers(), 0U);
}

}  // namespace
}  // namespace mlcca::relay
