// SPDX-License-Identifier: BSD-2-Clause
// mlcca-cluster with an etcd that loses members, is full, or has gone back.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <set>
#include <string>

#include "tests/cluster/gateway.hpp"
#include "tests/cluster/store.hpp"

namespace mlcca::test {
namespace {

using core::cluster::Entry;
using core::cluster::Outcome;
using core::cluster::Txn;
using std::chrono::seconds;

const std::string kOwn = "/mlcca/t/r/gw1/";

/// Until one is committed, again and again; each with a number of its own. A failure says what
/// became of the last one, and of the connection.
::testing::AssertionResult commits(const Loop& loop, Gateway& gateway,
                                   seconds patience = seconds(120)) {
  static std::uint64_t number = 1000;
  const auto start = std::chrono::steady_clock::now();
  std::set<std::string> whys;
  while (std::chrono::steady_clock::now() - start < patience) {
    const std::uint64_t id = ++number;
    Txn txn = creation(id, {kOwn + std::to_string(id)});
    txn.patience_ns = 1'000'000'000;
    gateway.link.send(txn);
    if (!loop.until([&] { return gateway.results.contains(id); }))
      return ::testing::AssertionFailure() << "there is no result: " << gateway.state.problem;
    if (gateway.results[id].outcome == Outcome::committed) return ::testing::AssertionSuccess();
    whys.insert(gateway.results[id].why);
    loop.until([&] { return false; }, std::chrono::milliseconds(20));
  }
  return ::testing::AssertionFailure()
         << ::testing::PrintToString(whys) << " state: " << gateway.state.problem;
}

TEST(ClusterMembers, OneOfThreeMayGoWhicheverItIs) {
  const WorkFolder folder;
  make_certificates(folder);
  Store store(folder, 3);
  const Loop loop;
  const std::size_t leader = store.leader();
  const std::size_t second = (leader + 1) % 3;
  const std::size_t third = (leader + 2) % 3;
  // The leader is asked first.
  const Bridged bridged(folder, "gw1",
                        {store.endpoint(leader), store.endpoint(second), store.endpoint(third)});
  Gateway gateway(loop.get(), bridged.socket(), {kOwn});
  ASSERT_TRUE(loop.until([&] { return gateway.state.reachable && gateway.synced != 0; }));
  ASSERT_TRUE(commits(loop, gateway));

  store.kill(leader);
  EXPECT_TRUE(commits(loop, gateway)) << bridged.log();
  // A transaction may be committed before the member that was asked has said that it is there.
  ASSERT_TRUE(loop.until([&] {
    return gateway.state.reachable && gateway.state.endpoint != store.endpoint(leader);
  })) << bridged.log();

  // Two of three are too few: a member without a leader is nobody to ask.
  const bool asks_second = gateway.state.endpoint == store.endpoint(second);
  store.kill(asks_second ? third : second);
  ASSERT_TRUE(loop.until([&] { return !gateway.state.reachable; })) << bridged.log();
  EXPECT_FALSE(commits(loop, gateway, seconds(1)));
  store.start(leader);
  store.start(asks_second ? third : second);
  ASSERT_TRUE(commits(loop, gateway)) << bridged.log();
  ASSERT_TRUE(loop.until([&] { return gateway.state.reachable && gateway.synced != 0; }));

  // One that stands still, whoever it is, is left for another one.
  const auto asked = gateway.state.endpoint;
  std::size_t stopped = 0;
  while (store.endpoint(stopped) != asked) ++stopped;
  store.pause(stopped);
  EXPECT_TRUE(commits(loop, gateway)) << bridged.log();
  EXPECT_TRUE(loop.until([&] {
    return gateway.state.reachable && gateway.synced != 0 && gateway.state.endpoint != asked;
  })) << bridged.log();
  store.resume(stopped);
  // Everything that was committed is there, once.
  ASSERT_TRUE(commits(loop, gateway));
  std::int64_t last = 0;
  for (const auto& [id, result] : gateway.results) last = std::max(last, result.revision);
  ASSERT_TRUE(loop.until([&] { return gateway.revision >= last && gateway.synced != 0; }));
  for (const auto& [id, result] : gateway.results) {
    const auto entry = gateway.entries.find(kOwn + std::to_string(id));
    if (result.outcome != Outcome::committed) continue;
    ASSERT_NE(entry, gateway.entries.end()) << id;
    EXPECT_EQ(entry->second.create, result.revision);
    EXPECT_EQ(entry->second.mod, result.revision);
  }
}

TEST(ClusterMembers, AFullStoreIsSaidToBeFull) {
  const WorkFolder folder;
  make_certificates(folder);
  const Store store(folder, 1, {"--quota-backend-bytes", "6000000"});
  const Loop loop;
  const Bridged bridged(folder, "gw1", {store.endpoint(0)});
  Gateway gateway(loop.get(), bridged.socket(), {kOwn});
  ASSERT_TRUE(loop.until([&] { return gateway.state.reachable; })) << bridged.log();
  constexpr std::uint64_t most = 500;
  std::uint64_t id = 0;
  bool full = false;
  while (!full && id < most) {
    ++id;
    gateway.link.send(creation(id, {kOwn + std::to_string(id)}, std::string(50'000, 'v')));
    ASSERT_TRUE(loop.until([&] { return gateway.results.contains(id); }));
    full = gateway.results[id].outcome == Outcome::full;
  }
  ASSERT_TRUE(full) << gateway.results[id].why;
  EXPECT_TRUE(loop.until([&] { return gateway.state.no_space; }));
  EXPECT_TRUE(loop.until([&] { return gateway.state.reachable; }));
  EXPECT_GT(gateway.state.db_bytes, 4'000'000U);
  Txn deletion{.id = 9000,
               .compares = {},
               .puts = {},
               .deletes = {kOwn + "1"},
               .else_get = {},
               .patience_ns = 3'000'000'000};
  gateway.link.send(deletion);
  ASSERT_TRUE(loop.until([&] { return gateway.results.contains(9000); }));
  EXPECT_EQ(gateway.results[9000].outcome, Outcome::committed) << gateway.results[9000].why;
  EXPECT_TRUE(loop.until([&] { return !gateway.entries.contains(kOwn + "1"); }));
}

TEST(ClusterMembers, AStoreThatWasRestoredHasGoneBackInASnapshotOfAnEarlierRevision) {
  const WorkFolder folder;
  make_certificates(folder);
  Store store(folder, 1);
  const Loop loop;
  const Bridged bridged(folder, "gw1", {store.endpoint(0)});
  Gateway gateway(loop.get(), bridged.socket(), {kOwn});
  ASSERT_TRUE(loop.until([&] { return gateway.state.reachable && gateway.synced != 0; }))
      << bridged.log();
  gateway.link.send(creation(1, {kOwn + "before"}));
  ASSERT_TRUE(loop.until([&] { return gateway.results.contains(1); }));
  ASSERT_TRUE(store.control("snapshot save saved"));
  gateway.link.send(creation(2, {kOwn + "lost"}));
  ASSERT_TRUE(loop.until([&] { return gateway.entries.contains(kOwn + "lost"); }));
  const std::int64_t seen = gateway.revision;
  const auto cluster = gateway.state.cluster_id;

  store.kill(0);
  ASSERT_TRUE(store.control(
      "snapshot restore saved --data-dir restored --name m0 --initial-cluster m0=" + store.peer() +
      " --initial-advertise-peer-urls " + store.peer()));
  store.set_data(folder / "restored");
  store.start(0);
  ASSERT_TRUE(loop.until([&] { return gateway.snapshots > 1 && gateway.synced != 0; }))
      << bridged.log();
  EXPECT_LT(gateway.begun, seen);
  EXPECT_FALSE(gateway.entries.contains(kOwn + "lost"));
  EXPECT_TRUE(gateway.entries.contains(kOwn + "before"));
  EXPECT_EQ(gateway.state.cluster_id, cluster) << "then the number of the cluster would tell";
}

}  // namespace
}  // namespace mlcca::test
