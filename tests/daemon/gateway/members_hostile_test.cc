// SPDX-License-Identifier: BSD-2-Clause
// What a gateway does to another one by what it writes into the store: a lease without an end.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <variant>

#include "core/cluster/lease.hpp"
#include "daemon/cluster/codec.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr std::uint64_t kHourNs = 3600 * kSecondNs;

/// The tests write for g1 what another program than mlccad could write.
class MembersHostile : public MembershipBench {
 protected:
  MembersHostile() : MembershipBench(with_a_described_publisher()) {}

  static std::string key(const std::string& kind) { return "/mlcca/pair/" + kind; }
  void write_beat(std::uint64_t lease) {
    const auto& was = store.entries.at(key("m/g1"));
    auto beat = codec.beat(was.value).value_or(cc::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    beat.digest = cc::Digest{1};
    beat.lease = lease;
    beat.applied = store.revision;
    beat.generation = 1;
    store.write({{.key = key("m/g1"), .value = codec.write(beat)}});
  }
  void write_endless_lease() {
    write_beat(std::numeric_limits<std::uint64_t>::max());
    run();
  }
  /// In long steps, as nothing happens but what time does.
  void wait(std::uint64_t time) {
    for (std::uint64_t gone = 0; gone < time; gone += 20 * kSecondNs) {
      for (auto& node : nodes) node->bench.clock.monotonic += 20 * kSecondNs;
      pass(kStepNs);
    }
  }
  std::string state_of_g1() {
    auto answer =
        at(0).ask(control::ClusterRequest{.part = "members", .network = {}, .gateway = {}});
    const auto* found = std::get_if<control::ClusterMembers>(&answer.reply.body);
    if (found == nullptr) return "no answer";
    for (const auto& one : found->members)
      if (one.name == "g1") return one.state;
    return {};
  }

  cluster::Codec codec{with_a_described_publisher(), cc::Digest{1}};
};

/// To start it with a lease that it may have is what status says about such an entry.
TEST_F(MembersHostile, WhoHadALeaseWithoutAnEndAndRestartsIsFencedWhenItDies) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c2", "own1", "shared")), "granted");
  at(1).end();
  write_endless_lease();
  start(1);
  pass(5 * kSecondNs);
  at(1).end();
  link(1).up = false;
  wait(kHourNs - (60 * kSecondNs));
  EXPECT_EQ(entries("f/"), 0U) << "the process before it may still send";
  wait(120 * kSecondNs);
  EXPECT_EQ(entries("f/"), 1U);
}

TEST_F(MembersHostile, WhoHadALeaseWithoutAnEndIsAbsentAnHourAfterItsEntryWasDeleted) {
  start_both();
  at(1).end();
  link(1).up = false;
  write_endless_lease();
  wait(2 * kHourNs);
  EXPECT_EQ(state_of_g1(), "silent") << "its entry is still there";
  store.write({}, {key("m/g1")});
  wait(kHourNs - (60 * kSecondNs));
  EXPECT_EQ(state_of_g1(), "silent");
  wait(120 * kSecondNs);
  EXPECT_EQ(state_of_g1(), "absent");
}

TEST_F(MembersHostile, AnEpochAfterALeaseWithoutAnEndIsUsedAnHourAfterItsBeginning) {
  start_both();
  at(1).end();
  write_endless_lease();
  store.write({{.key = key("e"), .value = std::string(16, 'x')}});
  run();
  wait(kHourNs + (60 * kSecondNs));
  const std::string waits = asked(0, wanted("c3", "own0", "shared"));
  EXPECT_TRUE(waits.contains("leases from before have not ended yet, and g1 states one of"))
      << waits;
  start(1);
  pass(4 * kSecondNs);
  EXPECT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
}

}  // namespace
}  // namespace mlcca::test
