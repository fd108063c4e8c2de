// SPDX-License-Identifier: BSD-2-Clause
// mlcca-cluster with the etcd of the distribution, one member.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cluster/etcd.hpp"
#include "cluster/http.hpp"
#include "tests/cluster/gateway.hpp"
#include "tests/cluster/store.hpp"
#include "tests/cluster/tunnel.hpp"
#include "tests/support/require.hpp"

namespace mlcca::test {
namespace {

using core::cluster::Compare;
using core::cluster::Outcome;
using core::cluster::Txn;

/// One store for all tests: each has keys of its own.
class ClusterStore : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new WorkFolder;
    make_certificates(*folder_);
    store_ = new Store(*folder_, 1);
  }
  static void TearDownTestSuite() {
    delete std::exchange(store_, nullptr);
    delete std::exchange(folder_, nullptr);
  }
  static WorkFolder& folder() { return *folder_; }
  static Store& store() { return *store_; }
  static std::string own(const std::string& name) { return "/mlcca/t/r/gw1/" + name; }

  Loop loop_;

 private:
  inline static WorkFolder* folder_ = nullptr;
  inline static Store* store_ = nullptr;
};

TEST_F(ClusterStore, ATransactionIsCommittedOnceAndThenConflicts) {
  const Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
  EXPECT_NE(gateway.state.cluster_id, 0U);
  EXPECT_GT(gateway.state.db_bytes, 0U);
  EXPECT_EQ(gateway.state.endpoint, store().endpoint(0));
  gateway.link.send(creation(1, {own("once"), "/mlcca/t/v/once"}, "first"));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  EXPECT_EQ(gateway.results[1].outcome, Outcome::committed) << gateway.results[1].why;
  Txn again = creation(2, {own("once"), "/mlcca/t/v/once"}, "second");
  again.else_get.push_back("/mlcca/t/v/nothing");
  gateway.link.send(again);
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(2); }));
  const auto& conflict = gateway.results[2];
  EXPECT_EQ(conflict.outcome, Outcome::conflict);
  ASSERT_EQ(conflict.read.size(), 3U);
  EXPECT_EQ(conflict.read[0].value, "first");
  EXPECT_EQ(conflict.read[0].mod, gateway.results[1].revision);
  EXPECT_FALSE(conflict.read[1].gone);
  EXPECT_TRUE(conflict.read[2].gone);
  EXPECT_EQ(conflict.read[2].key, "/mlcca/t/v/nothing");
  Txn less{.id = 3,
           .compares = {{.what = Compare::What::mod,
                         .is = Compare::Is::less,
                         .key = "/mlcca/t/v/nothing",
                         .revision = 1}},
           .puts = {},
           .deletes = {own("once")},
           .else_get = {},
           .patience_ns = 3'000'000'000};
  gateway.link.send(less);
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(3); }));
  EXPECT_EQ(gateway.results[3].outcome, Outcome::committed) << gateway.results[3].why;
}

TEST_F(ClusterStore, AnotherGatewaySeesASnapshotAndThenEachRevisionAtOnce) {
  const Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  const Bridged other(folder(), "gw2", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  gateway.link.send(creation(0, {}));
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
  gateway.link.send(creation(1, {own("seen/1"), "/mlcca/t/v/seen"}));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  Gateway watcher(loop_.get(), other.socket(), {own("seen/"), "/mlcca/t/v/seen"});
  ASSERT_TRUE(loop_.until([&] { return watcher.synced != 0; })) << other.log();
  EXPECT_EQ(watcher.entries.size(), 2U);
  // What is not followed is not sent, but up to which revision all is known is said.
  gateway.link.send(creation(2, {own("unseen")}));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(2); }));
  gateway.link.send(
      creation(3, {own("seen/2"), "/mlcca/t/v/seen2", own("seen/3"), own("unseen2")}));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(3); }));
  ASSERT_TRUE(loop_.until([&] { return watcher.revision >= gateway.results[3].revision; }));
  ASSERT_FALSE(watcher.changes.empty());
  EXPECT_EQ(watcher.changes.back().entries.size(), 3U);
  EXPECT_EQ(watcher.changes.back().revision, gateway.results[3].revision);
  ASSERT_TRUE(store().control("del " + own("seen/2")));
  EXPECT_TRUE(loop_.until([&] { return !watcher.entries.contains(own("seen/2")); }));
  EXPECT_EQ(watcher.entries.size(), 4U);
}

TEST_F(ClusterStore, ManyEntriesComeInPagesAndNoneIsMissing) {
  const Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
  constexpr std::uint64_t batches = 200;
  for (std::uint64_t id = 0; id < batches; ++id) {
    std::vector<std::string> keys;
    for (int i = 0; i < 100; ++i)
      keys.push_back(own("many/" + std::to_string(id) + "/" + std::to_string(i)));
    Txn txn = creation(id, keys);
    txn.else_get.clear();
    gateway.link.send(txn);
  }
  // A few that are so long that a page of them is longer than an answer may be.
  for (std::uint64_t id = batches; id < batches + 50; ++id)
    gateway.link.send(
        creation(id, {own("many/long" + std::to_string(id) + "a")}, std::string(60'000, 'v')));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.size() == batches + 50; }));
  for (const auto& [id, result] : gateway.results)
    EXPECT_EQ(result.outcome, Outcome::committed) << result.why;
  gateway.link.follow({own("many/"), "/mlcca/t/e"});
  ASSERT_TRUE(loop_.until([&] { return gateway.synced != 0; })) << bridged.log();
  EXPECT_EQ(gateway.entries.size(), 20'050U) << bridged.log();
  EXPECT_EQ(gateway.snapshots, 1);
}

TEST_F(ClusterStore, WhatTheRoleDoesNotAllowIsForbidden) {
  const Bridged bridged(folder(), "gw2", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
  gateway.link.send(creation(1, {own("foreign")}));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  EXPECT_EQ(gateway.results[1].outcome, Outcome::forbidden);
  EXPECT_NE(gateway.results[1].why.find("permission denied"), std::string::npos);
  gateway.link.follow({"/elsewhere/"});
  ASSERT_TRUE(loop_.until([&] { return !gateway.state.reachable; }));
  EXPECT_NE(gateway.state.problem.find("/elsewhere/"), std::string::npos) << gateway.state.problem;
  // What may be read is read, below what may not: the folder of both is refused to the watch.
  gateway.link.follow({"/mlcca/t/v/", "/mlcca/t/x/"});
  EXPECT_TRUE(loop_.until([&] { return gateway.synced != 0 && gateway.state.reachable; }));
}

TEST_F(ClusterStore, ATransactionThatEtcdDoesNotTakeIsInvalid) {
  const Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
  Txn twice = creation(1, {own("twice")});
  twice.puts.push_back(twice.puts[0]);
  gateway.link.send(twice);
  Txn empty_key = creation(2, {""});
  gateway.link.send(empty_key);
  ASSERT_TRUE(loop_.until([&] { return gateway.results.size() == 2; }));
  EXPECT_EQ(gateway.results[1].outcome, Outcome::invalid) << gateway.results[1].why;
  EXPECT_EQ(gateway.results[2].outcome, Outcome::invalid) << gateway.results[2].why;
}

TEST_F(ClusterStore, AnotherCertificateIsAProblemUntilTheRightOneIsThere) {
  ASSERT_TRUE(run_script("cp gw1-other.pem late.pem; cp gw1-other.key late.key", folder().path()));
  const Bridged bridged(folder(), "late", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return gateway.state.problem.starts_with("https://"); }));
  EXPECT_FALSE(gateway.state.reachable);
  gateway.link.send(creation(1, {own("late")}));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  EXPECT_TRUE(gateway.results[1].outcome == Outcome::unavailable ||
              gateway.results[1].outcome == Outcome::unsure);
  ASSERT_TRUE(run_script("cp gw1.pem late.pem; cp gw1.key late.key", folder().path()));
  EXPECT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
}

TEST_F(ClusterStore, AServerOfAnotherAuthorityIsNotSpokenTo) {
  ASSERT_TRUE(
      run_script("mkdir -p deceived; cp gw1.pem gw1.key deceived; cp other.pem deceived/ca.pem",
                 folder().path()));
  const Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  write_file(folder() / "deceived.conf", "endpoint = " + store().endpoint(0) +
                                             "\nca = " + folder() / "other.pem" +
                                             "\ncertificate = " + folder() / "gw1.pem" +
                                             "\nkey = " + folder() / "gw1.key" + '\n');
  const std::string socket = folder() / "deceived.socket";
  const Program program(
      {built("mlcca-cluster"), "--settings", folder() / "deceived.conf", "--socket", socket},
      folder() / "deceived.log");
  Gateway gateway(loop_.get(), socket);
  ASSERT_TRUE(loop_.until([&] { return gateway.state.problem.starts_with("https://"); }));
  EXPECT_NE(gateway.state.problem.find("certificate"), std::string::npos) << gateway.state.problem;
}

TEST_F(ClusterStore, ANameIsLookedUpInTheSandbox) {
  const Bridged bridged(folder(), "gw1", {"https://localhost:" + std::to_string(store().port(0))});
  Gateway gateway(loop_.get(), bridged.socket());
  EXPECT_TRUE(loop_.until([&] { return gateway.state.reachable; }))
      << gateway.state.problem << bridged.log();
}

TEST_F(ClusterStore, AConnectionCutBeforeTheAnswerIsUnsureAndNothingIsSentTwice) {
  // A reset is what libcurl takes for a connection that was not used for long, and tries again.
  for (const bool resets : {false, true}) {
    Tunnel tunnel(loop_.get(), store().port(0));
    const Bridged bridged(folder(), "gw1", {"https://127.0.0.1:" + std::to_string(tunnel.port())});
    Gateway gateway(loop_.get(), bridged.socket());
    ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; })) << bridged.log();
    const std::string key = own("cut" + std::to_string(resets ? 1 : 0));
    tunnel.cut_at_next_answer(resets);
    Txn txn = creation(1, {key});
    txn.compares.clear();  // it could be carried out twice
    gateway.link.send(txn);
    ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
    EXPECT_EQ(gateway.results[1].outcome, Outcome::unsure) << gateway.results[1].why;
    // It was carried out once: the key is as it was created.
    gateway.link.follow({key});
    ASSERT_TRUE(loop_.until([&] { return gateway.synced != 0 && gateway.entries.contains(key); }));
    EXPECT_EQ(gateway.entries[key].create, gateway.entries[key].mod);
  }
}

TEST_F(ClusterStore, AStoreThatHangsIsNoticedInTime) {
  Tunnel tunnel(loop_.get(), store().port(0));
  const Bridged bridged(folder(), "gw1", {"https://127.0.0.1:" + std::to_string(tunnel.port())},
                        "timeout = 300\n");
  Gateway gateway(loop_.get(), bridged.socket(), {own("hang")});
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable && gateway.synced != 0; }))
      << bridged.log();
  tunnel.hold(true);
  Txn txn = creation(1, {own("hang")});
  txn.patience_ns = 200'000'000;
  gateway.link.send(txn);
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  EXPECT_EQ(gateway.results[1].outcome, Outcome::unsure) << gateway.results[1].why;
  ASSERT_TRUE(loop_.until([&] { return !gateway.state.reachable; }));
  const int before = gateway.snapshots;
  tunnel.hold(false);
  EXPECT_TRUE(loop_.until([&] {
    return gateway.state.reachable && gateway.snapshots > before && gateway.synced != 0;
  }));
}

/// A peer says nothing more after so many octets, which may be within a handshake, an answer, or
/// between two of them.
class FallsSilent {
 public:
  FallsSilent(sd_event* loop, int port, const WorkFolder& folder, std::size_t after,
              bool half_closes, std::uint64_t limit_ms)
      : limit_ms_(limit_ms), tunnel_(loop, port) {
    tunnel_.fall_silent(after, half_closes);
    const std::string endpoint = "https://127.0.0.1:" + std::to_string(tunnel_.port());
    auto channel = cluster::open_http(loop,
                                      {.endpoints = {endpoint},
                                       .ca = folder / "ca.pem",
                                       .certificate = folder / "gw1.pem",
                                       .key = folder / "gw1.key",
                                       .timeout_ms = limit_ms_},
                                      endpoint);
    require(channel.has_value(), "a channel");
    channel_ = std::move(*channel);
    // The watch has no limit: it is over when the connection is given up.
    calls_.push_back(
        channel_->start({.method = cluster::etcd::kWatch,
                         .message = cluster::etcd::watch_request("/mlcca/t/", "/mlcca/t0", 1),
                         .stays_open = true,
                         .on_answer = [](const std::string&) {},
                         .on_end = [](const cluster::End&) {}}));
    ask_both();
  }

  void ask_both() {
    ask(cluster::etcd::kStatus, {});
    ask(cluster::etcd::kTxn, cluster::etcd::txn_request(creation(1, {"/mlcca/t/r/gw1/silent"})));
  }
  [[nodiscard]] bool all_ended() const { return open_ == 0; }
  void close() {
    calls_.clear();
    channel_.reset();
  }
  [[nodiscard]] const Tunnel& tunnel() const { return tunnel_; }

 private:
  void ask(std::string_view method, std::string message) {
    ++open_;
    calls_.push_back(channel_->start({.method = method,
                                      .message = std::move(message),
                                      .timeout_ms = limit_ms_,
                                      .on_answer = [](const std::string&) {},
                                      .on_end = [this](const cluster::End&) { --open_; }}));
  }

  std::uint64_t limit_ms_;
  Tunnel tunnel_;
  std::unique_ptr<cluster::Channel> channel_;
  std::vector<std::unique_ptr<cluster::Call>> calls_;
  int open_ = 0;
};

TEST_F(ClusterStore, ACallEndsInItsTimeWhereverThePeerFallsSilent) {
  require(cluster::prepare_http().has_value(), "libcurl");
  constexpr std::size_t never = 1'000'000;
  constexpr std::uint64_t longest = 50'000;  // ms; for all octets on a busy machine
  FallsSilent whole(loop_.get(), store().port(0), folder(), never, false, longest);
  ASSERT_TRUE(loop_.until([&] { return whole.all_ended(); }));
  const std::size_t all = whole.tunnel().octets_of_server();
  ASSERT_GT(all, 1000U);

  std::vector<std::unique_ptr<FallsSilent>> peers;
  for (std::size_t after = 0; after <= all; after += all / 30)
    for (const bool half_closes : {false, true})
      peers.push_back(std::make_unique<FallsSilent>(loop_.get(), store().port(0), folder(), after,
                                                    half_closes, 500));
  const auto all_ended = [&] {
    return std::ranges::all_of(peers, [](const auto& peer) { return peer->all_ended(); });
  };
  ASSERT_TRUE(loop_.until(all_ended));
  // On the connection that the peer has left, too.
  for (const auto& peer : peers) peer->ask_both();
  ASSERT_TRUE(loop_.until(all_ended));
  for (const auto& peer : peers) peer->close();
  EXPECT_TRUE(loop_.until([&] {
    return std::ranges::all_of(peers,
                               [](const auto& peer) { return peer->tunnel().connections() == 0; });
  }));
}

TEST_F(ClusterStore, AMemberThatFallsSilentIsLeftAndTriedAgain) {
  for (const std::string name : {"all-silent", "half-closed"}) {
    Tunnel tunnel(loop_.get(), store().port(0));
    const Bridged bridged(folder(), "gw1", {"https://127.0.0.1:" + std::to_string(tunnel.port())});
    Gateway gateway(loop_.get(), bridged.socket(), {own(name)});
    gateway.link.send(creation(0, {}));
    ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable && gateway.synced != 0; }))
        << bridged.log();
    gateway.link.send(creation(1, {own(name)}));
    ASSERT_TRUE(loop_.until([&] { return !gateway.changes.empty(); })) << "it watches";
    const std::size_t before = gateway.states.size();
    tunnel.fall_silent(name == "half-closed");
    Txn txn = creation(2, {own(name) + "2"});
    txn.patience_ns = 200'000'000;
    gateway.link.send(txn);
    ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(2); }));
    ASSERT_TRUE(loop_.until([&] {
      return std::any_of(gateway.states.begin() + static_cast<std::ptrdiff_t>(before),
                         gateway.states.end(), [](const auto& state) { return !state.reachable; });
    })) << name
        << bridged.log();
    EXPECT_TRUE(loop_.until([&] { return gateway.state.reachable && gateway.synced != 0; }))
        << bridged.log();
    EXPECT_TRUE(loop_.until([&] { return tunnel.connections() == 1; })) << "the old one is closed";
  }
}

TEST_F(ClusterStore, ASnapshotThatWasCompactedBeginsAgain) {
  const Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  Gateway writer(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return writer.state.reachable; })) << bridged.log();
  for (std::uint64_t id = 0; id < 300; ++id) {
    writer.link.send(
        creation(id, {own("compact/" + std::to_string(id))}, std::string(60'000, 'v')));
    if (id % 30 == 29) {
      ASSERT_TRUE(loop_.until([&] { return writer.results.size() == id + 1; }));
    }
  }
  // All of them are more than one answer may have. One that gives no credit: the second page is
  // asked for late.
  const Bridged slow(folder(), "gw2", {store().endpoint(0)});
  SlowReader reader(slow.socket(), {own("compact/")});
  ASSERT_TRUE(reader.read_until<ClusterSnapshot>()) << slow.log();
  const std::int64_t first = reader.revision();
  ASSERT_TRUE(store().control("put /mlcca/t/v/compact 1"));
  ASSERT_TRUE(store().control(
      "compaction $(etcdctl $ROOT get -w json x | sed 's/.*\"revision\":\\([0-9]*\\).*/\\1/')"));
  reader.give_credit(100'000);
  ASSERT_TRUE(reader.read_until<ClusterSnapshot>()) << slow.log();
  EXPECT_GT(reader.revision(), first);
  ASSERT_TRUE(reader.read_until<ClusterSynced>()) << slow.log();
  // On a busy machine an answer may be too late.
  const auto committed = std::ranges::count_if(writer.results, [](const auto& result) {
    return result.second.outcome == Outcome::committed;
  });
  EXPECT_GE(reader.entries(), static_cast<std::size_t>(committed));
  EXPECT_LE(reader.entries(), 300U);
}

TEST_F(ClusterStore, ProgramsEndAsTheyAreToldTo) {
  Bridged bridged(folder(), "gw1", {store().endpoint(0)});
  Gateway gateway(loop_.get(), bridged.socket());
  ASSERT_TRUE(loop_.until([&] { return gateway.state.reachable; }));
  bridged.program.signal(SIGTERM);
  EXPECT_EQ(bridged.program.wait(), 0);
  ASSERT_TRUE(loop_.until([&] { return !gateway.state.reachable; }));
  write_file(folder() / "wrong.conf", "endpoint = http://127.0.0.1\n");
  Program wrong({built("mlcca-cluster"), "--check", "--settings", folder() / "wrong.conf"},
                folder() / "wrong.log");
  EXPECT_EQ(wrong.wait(), 2);
  EXPECT_TRUE(text_of_file(folder() / "wrong.log").starts_with(folder() / "wrong.conf" + ":1: "));
}

}  // namespace
}  // namespace mlcca::test
