// SPDX-License-Identifier: BSD-2-Clause
// The bridge with a store that answers what a test says: what no real one does, and what a real one
// does too seldom.
#include "cluster/bridge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <protozero/pbf_writer.hpp>
#include <variant>

#include "cluster/grpc.hpp"
#include "tests/cluster/fake_channel.hpp"
#include "tests/cluster/gateway.hpp"

namespace mlcca::cluster {
namespace {

using core::cluster::Batch;
using core::cluster::Outcome;
using core::cluster::StoreState;
using core::cluster::TxnResult;
using protozero::pbf_writer;

struct Kv {
  std::string key, value;
  std::int64_t mod = 1;
  bool gone = false;
};

std::string header(std::int64_t revision) {
  std::string out;
  pbf_writer to(out);
  to.add_uint64(1, 77);
  to.add_int64(3, revision);
  return out;
}
std::string key_value(const Kv& kv) {
  std::string out;
  pbf_writer to(out);
  to.add_bytes(1, kv.key);
  to.add_int64(2, kv.mod);
  to.add_int64(3, kv.mod);
  to.add_bytes(5, kv.value);
  return out;
}
std::string page(std::int64_t revision, const std::vector<Kv>& all, bool more = false) {
  std::string out;
  pbf_writer to(out);
  to.add_message(1, header(revision));
  for (const Kv& kv : all) to.add_message(2, key_value(kv));
  if (more) to.add_bool(3, true);
  return out;
}
std::string changes(std::int64_t revision, const std::vector<Kv>& all) {
  std::string out;
  pbf_writer to(out);
  to.add_message(1, header(revision));
  for (const Kv& kv : all) {
    std::string event;
    pbf_writer into(event);
    if (kv.gone) into.add_enum(1, 1);
    into.add_message(2, key_value(kv));
    to.add_message(11, event);
  }
  return out;
}
std::string canceled(std::int64_t compacted) {
  std::string out;
  pbf_writer to(out);
  to.add_message(1, header(50));
  to.add_bool(4, true);
  to.add_int64(5, compacted);
  return out;
}
std::string status(std::uint64_t leader, const std::string& error = {}) {
  std::string out;
  pbf_writer to(out);
  to.add_message(1, header(5));
  to.add_int64(3, 4096);
  to.add_uint64(4, leader);
  if (!error.empty()) to.add_string(8, error);
  return out;
}

std::string committed(std::int64_t revision) {
  std::string out;
  pbf_writer to(out);
  to.add_message(1, header(revision));
  to.add_bool(2, true);
  return out;
}

class ClusterBridge : public ::testing::Test {
 protected:
  ClusterBridge()
      : bridge_(loop_.get(),
                {.endpoints = {"https://a:1", "https://b:1"},
                 .ca = {},
                 .certificate = {},
                 .key = {},
                 .timeout_ms = 100},
                {.open = [this](const std::string& endpoint) -> Result<std::unique_ptr<Channel>> {
                   opened_.push_back(endpoint);
                   if (refuses_) return fail("no memory");
                   return std::make_unique<test::FakeChannel>(calls_);
                 },
                 .log = [this](const std::string& line) { logged_.push_back(line); }}) {
    EXPECT_TRUE(bridge_.start().has_value());
  }
  ~ClusterBridge() override { bridge_.end_session(); }

  /// The oldest call of that method that has not been dropped, waited for.
  test::FakeCall& call(std::string_view method) {
    std::shared_ptr<test::FakeCall> found;
    EXPECT_TRUE(loop_.until([&] {
      for (const auto& one : calls_)
        if (!found && !one->dropped && one->request.method == method) found = one;
      return found != nullptr;
    })) << method;
    kept_.push_back(found ? found : std::make_shared<test::FakeCall>());
    return *kept_.back();
  }
  void finish(test::FakeCall& call, const std::string& answer) {
    call.answer(answer);
    if (!call.dropped) call.end(grpc::kOk);
  }
  void connect(std::vector<std::string> prefixes = {}) {
    bridge_.take(wire::Hello{"t", "gw"});
    if (!prefixes.empty()) bridge_.take(wire::Follow{std::move(prefixes)});
    bridge_.take(wire::Credit{1'000'000});
    finish(call(etcd::kStatus), status(1));
  }
  /// Answers a status request if there is one; always true.
  bool answers_status() {
    const auto open = std::ranges::find_if(calls_, [](const auto& one) {
      return !one->dropped && one->request.method == etcd::kStatus;
    });
    if (open != calls_.end()) finish(**open, status(1));
    return true;
  }
  /// Everything that waits for mlccad.
  std::vector<ClusterMessage> drain() {
    std::vector<ClusterMessage> out;
    while (const auto* message = bridge_.outbox().next()) {
      auto read = reader_.take(*message);
      EXPECT_TRUE(read.has_value());
      if (read && read->whole) out.push_back(std::move(*read->whole));
      bridge_.outbox().take();
    }
    bridge_.sent();
    return out;
  }
  template <class Kind>
  std::vector<Kind> drain_of() {
    std::vector<Kind> out;
    for (auto& message : drain())
      if (auto* one = std::get_if<Kind>(&message)) out.push_back(std::move(*one));
    return out;
  }

  test::Loop loop_;
  test::FakeChannel::Calls calls_;
  std::vector<std::shared_ptr<test::FakeCall>> kept_;
  std::vector<std::string> opened_;
  std::vector<std::string> logged_;
  bool refuses_ = false;
  Bridge bridge_;
  wire::ReaderOfStore reader_;
};

TEST_F(ClusterBridge, AsksNothingBeforeSomebodyIsThere) {
  loop_.until([] { return false; }, std::chrono::milliseconds(50));
  EXPECT_TRUE(opened_.empty());
  connect();
  EXPECT_EQ(opened_, (std::vector<std::string>{"https://a:1"}));
  const auto states = drain_of<StoreState>();
  ASSERT_EQ(states.size(), 1U);
  EXPECT_TRUE(states[0].reachable);
  EXPECT_EQ(states[0].cluster_id, 77U);
  EXPECT_EQ(states[0].db_bytes, 4096U);
}

TEST_F(ClusterBridge, GivesASnapshotInPagesAndThenRevisions) {
  connect({"/t/a/", "/t/b/", "/t/a/within/"});
  finish(call(etcd::kRange), page(9, {{"/t/a/1", "x"}, {"/t/a/2", "x"}}, true));
  finish(call(etcd::kRange), page(11, {{"/t/a/3", "x"}}));
  finish(call(etcd::kRange), page(12, {}));
  call(etcd::kWatch).answer(changes(12, {}));
  call(etcd::kWatch)
      .answer(changes(13, {{"/t/a/1", "y", 12},
                           {"/t/elsewhere", "y", 12},
                           {"/t/b/1", "", 12, true},
                           {"/t/c", "", 13}}));
  const auto said = drain();
  std::string kinds;
  for (const auto& message : said) kinds += std::to_string(message.index());
  EXPECT_EQ(kinds, "0122322") << "state, begin, two pages, synced, two revisions";
  EXPECT_EQ(std::get<ClusterSnapshot>(said[1]).revision, 9);
  EXPECT_EQ(std::get<Batch>(said[2]).entries.size(), 2U);
  const auto& first = std::get<Batch>(said[5]);
  EXPECT_EQ(first.revision, 12);
  ASSERT_EQ(first.entries.size(), 2U);
  EXPECT_TRUE(first.entries[1].gone);
  EXPECT_EQ(std::get<Batch>(said[6]).revision, 13);
  EXPECT_TRUE(std::get<Batch>(said[6]).entries.empty());
}

TEST_F(ClusterBridge, TakesANewSnapshotWhenTheWatchWasCompacted) {
  connect({"/t/a/"});
  finish(call(etcd::kRange), page(9, {{"/t/a/1", "x"}}));
  call(etcd::kWatch).answer(canceled(40));
  finish(call(etcd::kRange), page(50, {{"/t/a/2", "x"}}));
  const auto snapshots = drain_of<ClusterSnapshot>();
  ASSERT_FALSE(snapshots.empty());
  EXPECT_EQ(snapshots.back().revision, 50);
  EXPECT_EQ(opened_.size(), 1U) << "it is no fault of the member";
}

TEST_F(ClusterBridge, TakesANewSnapshotWhenASnapshotWasCompactedOrTheStoreHasGoneBack) {
  connect({"/t/a/"});
  call(etcd::kRange)
      .end(grpc::kOutOfRange, "etcdserver: mvcc: required revision has been compacted");
  finish(call(etcd::kRange), page(50, {}));
  call(etcd::kWatch).answer(changes(8, {}));
  finish(call(etcd::kRange), page(8, {}));
  const auto snapshots = drain_of<ClusterSnapshot>();
  ASSERT_FALSE(snapshots.empty());
  EXPECT_EQ(snapshots.back().revision, 8);
}

TEST_F(ClusterBridge, AsksForFewerEntriesWhereTheyAreTooLong) {
  connect({"/t/a/"});
  const auto first = call(etcd::kRange).request.message;
  call(etcd::kRange)
      .request.on_end(
          {.status = End::kNoStatus, .text = "too long", .sent = true, .too_long = true});
  EXPECT_NE(call(etcd::kRange).request.message, first);
  finish(call(etcd::kRange), page(9, {}));
  EXPECT_EQ(drain_of<ClusterSynced>().size(), 1U);
  EXPECT_EQ(opened_.size(), 1U);
}

TEST_F(ClusterBridge, WaitsWithTheNextPageUntilTheLatestWasTaken) {
  bridge_.take(wire::Hello{"t", "gw"});
  bridge_.take(wire::Follow{{"/t/a/"}});
  finish(call(etcd::kStatus), status(1));
  std::vector<Kv> large;
  for (int i = 0; i < 100; ++i)
    large.push_back({"/t/a/" + std::to_string(1000 + i), std::string(50'000, 'v')});
  finish(call(etcd::kRange), page(9, large, true));
  const std::size_t before = calls_.size();
  EXPECT_TRUE(drain_of<Batch>().empty()) << "there is no credit";
  EXPECT_EQ(calls_.size(), before);
  bridge_.take(wire::Credit{100});
  EXPECT_EQ(drain_of<Batch>().size(), 100U) << "each message is one";
  finish(call(etcd::kRange), page(9, {}));
  EXPECT_EQ(drain_of<ClusterSynced>().size(), 1U);
}

TEST_F(ClusterBridge, APageMayBeLongerThanARevision) {
  connect({"/t/a/"});
  const std::vector<Kv> large(200, {"/t/a/1", std::string(60'000, 'v')});
  finish(call(etcd::kRange), page(9, large));
  std::size_t entries = 0;
  for (const auto& batch : drain_of<Batch>()) entries += batch.entries.size();
  EXPECT_EQ(entries, 200U);
}

TEST_F(ClusterBridge, BeginsAgainWhenMlccadIsTooSlowForChanges) {
  connect({"/t/a/"});
  finish(call(etcd::kRange), page(1, {}));
  for (int revision = 2; revision < 400 && !call(etcd::kWatch).dropped; ++revision) {
    auto& watch = call(etcd::kWatch);
    watch.answer(changes(revision, {{"/t/a/1", std::string(60'000, 'v'), revision}}));
    if (watch.dropped) break;
  }
  EXPECT_LT(bridge_.outbox().fed_bytes(), 1'000'000U);
  finish(call(etcd::kRange), page(500, {}));
  EXPECT_EQ(drain_of<ClusterSnapshot>().back().revision, 500);
}

TEST_F(ClusterBridge, ARevisionOfTooManyChangesIsTakenAsASnapshot) {
  connect({"/t/a/"});
  finish(call(etcd::kRange), page(1, {}));
  std::vector<Kv> many(wire::kMaxBatch + 1, {"/t/a/1", "", 2, true});
  call(etcd::kWatch).answer(changes(2, many));
  finish(call(etcd::kRange), page(2, {}));
  EXPECT_EQ(drain_of<ClusterSynced>().back().revision, 2);
}

TEST_F(ClusterBridge, GoesToAnotherMemberWhenOneKnowsNoLeader) {
  bridge_.take(wire::Hello{"t", "gw"});
  finish(call(etcd::kStatus), status(0));
  finish(call(etcd::kStatus), status(1));
  EXPECT_EQ(opened_, (std::vector<std::string>{"https://a:1", "https://b:1"}));
  EXPECT_TRUE(drain_of<StoreState>().back().reachable);
}

TEST_F(ClusterBridge, GoesToAnotherMemberWhenAnAnswerIsNotUnderstood) {
  connect({"/t/a/"});
  for (const std::string& wrong :
       {std::string("\xff"), page(0, {}), page(5, {}, true), page(-1, {})}) {
    const std::size_t before = opened_.size();
    finish(call(etcd::kRange), wrong);
    finish(call(etcd::kStatus), status(1));
    EXPECT_EQ(opened_.size(), before + 1);
  }
  finish(call(etcd::kRange), page(5, {}));
  const std::size_t before = opened_.size();
  call(etcd::kWatch).answer(changes(6, {{"/t/a/1", "x", 5}}));
  finish(call(etcd::kStatus), status(1));
  EXPECT_EQ(opened_.size(), before + 1) << "revision 5 is known";
}

TEST_F(ClusterBridge, TransactionsUnderWayEndWithTheMember) {
  connect();
  auto txn = test::creation(1, {"/t/a"});
  bridge_.take(txn);
  auto& sent = call(etcd::kTxn);
  txn.id = 2;
  bridge_.take(txn);
  calls_.back()->sent = false;
  loop_.until([&] { return false; }, std::chrono::milliseconds(250));
  call(etcd::kStatus).end(End::kNoStatus, "reset");
  EXPECT_TRUE(sent.dropped);
  auto results = drain_of<TxnResult>();
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[0].outcome, Outcome::unsure);
  EXPECT_EQ(results[1].outcome, Outcome::unavailable);
}

TEST_F(ClusterBridge, AskingAgainWhileATransactionOfThatNumberIsUnderWayIsInvalid) {
  connect();
  bridge_.take(test::creation(1, {"/t/a"}));
  bridge_.take(test::creation(1, {"/t/b"}));
  const auto results = drain_of<TxnResult>();
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].outcome, Outcome::invalid);
}

TEST_F(ClusterBridge, IsBusyWithAsManyTransactionsAsItTakes) {
  connect();
  std::uint64_t id = 0;
  while (!bridge_.is_busy() && id < 1000) bridge_.take(test::creation(++id, {"/t/a"}));
  EXPECT_EQ(id, 64U);
  call(etcd::kTxn).end(grpc::kPermissionDenied, "no");
  EXPECT_FALSE(bridge_.is_busy());
}

TEST_F(ClusterBridge, AnAnswerToATransactionThatIsNotUnderstoodIsUnsure) {
  connect();
  bridge_.take(test::creation(1, {"/t/a"}));
  finish(call(etcd::kTxn), "\xff");
  bridge_.take(test::creation(2, {"/t/a"}));
  finish(call(etcd::kTxn), page(5, {}));  // not succeeded, and nothing was read
  for (const auto& result : drain_of<TxnResult>()) EXPECT_EQ(result.outcome, Outcome::unsure);
}

TEST_F(ClusterBridge, SaysThatTheStoreIsFull) {
  bridge_.take(wire::Hello{"t", "gw"});
  finish(call(etcd::kStatus), status(1, "memberID:1 alarm:NOSPACE "));
  EXPECT_TRUE(drain_of<StoreState>().back().no_space);
}

TEST_F(ClusterBridge, OfAStoreThatDoesNotAnswerNothingIsKnown) {
  bridge_.take(wire::Hello{"t", "gw"});
  finish(call(etcd::kStatus), status(1, "memberID:1 alarm:NOSPACE "));
  ASSERT_TRUE(drain_of<StoreState>().back().no_space);
  loop_.until([&] { return calls_.size() > 1; });
  call(etcd::kStatus).end(End::kNoStatus, "it is gone");
  const auto state = drain_of<StoreState>().back();
  EXPECT_FALSE(state.reachable);
  EXPECT_FALSE(state.no_space) << "it may have been emptied since";
  EXPECT_EQ(state.db_bytes, 0U);
  EXPECT_EQ(state.latency_ns, 0U);
}

TEST_F(ClusterBridge, WhereNoChannelCanBeMadeItIsTriedAgain) {
  refuses_ = true;
  bridge_.take(wire::Hello{"t", "gw"});
  bridge_.take(test::creation(1, {"/t/a"}));
  EXPECT_EQ(drain_of<TxnResult>().at(0).outcome, Outcome::unavailable);
  ASSERT_TRUE(loop_.until([&] { return opened_.size() > 2; }));
  refuses_ = false;
  finish(call(etcd::kStatus), status(1));
  EXPECT_TRUE(drain_of<StoreState>().back().reachable);
}

TEST_F(ClusterBridge, ALossOfTheStoreIsLoggedOnceWithItsReasonAndSoIsItsReturn) {
  connect();
  logged_.clear();
  loop_.until([&] { return calls_.size() > 1; });
  for (int n = 0; n < 6; ++n)
    call(etcd::kStatus).end(End::kNoStatus, "reason " + std::to_string(n));
  ASSERT_EQ(logged_.size(), 1U);
  EXPECT_EQ(logged_[0], "the store is lost: https://a:1: reason 0");
  finish(call(etcd::kStatus), status(1));
  ASSERT_EQ(logged_.size(), 2U);
  EXPECT_TRUE(logged_[1].ends_with(" answers")) << logged_[1];
  // The next loss comes too soon.
  call(etcd::kStatus).end(End::kNoStatus, "once more");
  finish(call(etcd::kStatus), status(1));
  EXPECT_EQ(logged_.size(), 2U) << logged_.back();
}

/// The watch is open, and status requests are answered on the same connection.
TEST_F(ClusterBridge, AWatchThatDoesNotReportWhatWasCommittedIsGivenUp) {
  connect({"/t/"});
  finish(call(etcd::kRange), page(9, {}));
  call(etcd::kWatch).answer(changes(9, {}));
  auto txn = test::creation(1, {"/t/a"});
  bridge_.take(txn);
  finish(call(etcd::kTxn), committed(10));
  ASSERT_TRUE(loop_.until([&] { return answers_status() && opened_.size() == 2; }));
  EXPECT_EQ(std::ranges::count(logged_, "the store is lost: https://a:1: the watch stands still"),
            1);
}

TEST_F(ClusterBridge, AWatchIsNotExpectedToReportWhatIsNotFollowed) {
  connect({"/t/a/"});
  finish(call(etcd::kRange), page(9, {}));
  call(etcd::kWatch).answer(changes(9, {}));
  bridge_.take(test::creation(1, {"/elsewhere"}));
  finish(call(etcd::kTxn), committed(10));
  bridge_.take(test::creation(2, {"/t/a/1"}));
  finish(call(etcd::kTxn), committed(11));
  call(etcd::kWatch).answer(changes(11, {{"/t/a/1", "x", 11}}));
  EXPECT_FALSE(loop_.until([&] { return answers_status() && opened_.size() == 2; },
                           std::chrono::milliseconds(800)));
}

TEST_F(ClusterBridge, AConnectionThatDoesNotKeepTheTimeOfACallIsGivenUp) {
  connect();
  bridge_.take(test::creation(1, {"/t/a"}));
  call(etcd::kTxn)
      .request.on_end({.status = End::kNoStatus, .text = "no answer", .sent = true, .stuck = true});
  const auto results = drain_of<TxnResult>();
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].outcome, Outcome::unsure);
  EXPECT_TRUE(loop_.until([&] { return opened_.size() == 2; }));
}

TEST_F(ClusterBridge, NothingIsAskedAfterMlccadHasGone) {
  connect({"/t/a/"});
  finish(call(etcd::kRange), page(9, {}));
  bridge_.take(test::creation(1, {"/t/a"}));
  bridge_.end_session();
  for (const auto& one : calls_) EXPECT_TRUE(one->dropped);
  EXPECT_EQ(bridge_.outbox().next(), nullptr);
}

TEST(ClusterPrefixes, TheFolderIsThatOfAll) {
  EXPECT_EQ(Prefixes({"/m/t/e", "/m/t/d/", "/m/t/v/n1"}).folder(), "/m/t/");
  EXPECT_EQ(Prefixes({"/m/t/d/"}).folder(), "/m/t/d/");
  EXPECT_EQ(Prefixes({"/a/", "b"}).folder(), "");
  const Prefixes some({"/m/b/", "/m/b/x", "/m/a"});
  EXPECT_EQ(some.all(), (std::vector<std::string>{"/m/a", "/m/b/"}));
  EXPECT_TRUE(some.has("/m/ab") && some.has("/m/b/x") && some.has("/m/b/"));
  EXPECT_FALSE(some.has("/m/b") || some.has("/m/") || some.has("/m/c") || some.has(""));
}

TEST(ClusterEtcd, TheEndOfAPrefixIsBehindAllThatBeginWithIt) {
  EXPECT_EQ(etcd::end_of("/a/"), "/a0");
  EXPECT_EQ(etcd::end_of("a\xff"), "b");
  EXPECT_EQ(etcd::end_of("\xff"), std::string(1, '\0'));
}

}  // namespace
}  // namespace mlcca::cluster
