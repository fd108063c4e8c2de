// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/cluster/wire.hpp"

#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

namespace mlcca::cluster::wire {
namespace {

using core::cluster::Batch;
using core::cluster::Compare;
using core::cluster::Entry;
using core::cluster::Outcome;
using core::cluster::StoreState;
using core::cluster::Txn;
using core::cluster::TxnResult;

Txn some_txn() {
  return {
      .id = 7,
      .compares =
          {{.what = Compare::What::mod, .is = Compare::Is::less, .key = "a", .revision = 3},
           {.what = Compare::What::create, .is = Compare::Is::equal, .key = "b", .revision = 0}},
      .puts = {{.key = "c", .value = std::string("\0x", 2)}},
      .deletes = {"d"},
      .else_get = {"e", "f"},
      .patience_ns = 2'000'000};
}

Entry entry(const std::string& key) { return {.key = key, .value = {}}; }

template <class T>
T read_of_gateway(const std::vector<Message>& messages) {
  ReaderOfGateway reader;
  for (const Message& message : messages) {
    const auto read = reader.take(message);
    EXPECT_TRUE(read.has_value());
    if (read && *read) return std::get<T>(**read);
  }
  ADD_FAILURE() << "it is not whole";
  return {};
}

template <class T>
T read_of_store(const std::vector<Message>& messages) {
  ReaderOfStore reader;
  for (const Message& message : messages) {
    auto read = reader.take(message);
    EXPECT_TRUE(read.has_value());
    if (read && read->whole) return std::get<T>(*read->whole);
  }
  ADD_FAILURE() << "it is not whole";
  return {};
}

std::vector<Message> messages_of_batch(const Batch& batch) {
  std::vector<Message> out;
  for (std::size_t next = 0; next < batch.entries.size();)
    out.push_back(message_of(batch, next, kMaxBatch, false));
  return out;
}

TEST(ClusterWire, WhatAGatewaySendsArrivesAsItWasSent) {
  EXPECT_EQ(read_of_gateway<Hello>({message_of(Hello{"robots", "gw1"})}), (Hello{"robots", "gw1"}));
  EXPECT_EQ(read_of_gateway<Follow>({message_of(Follow{{"/a/", "/b"}})}).prefixes,
            (std::vector<std::string>{"/a/", "/b"}));
  EXPECT_EQ(read_of_gateway<Credit>({message_of(Credit{4096})}).entries, 4096U);
  const auto messages = messages_of(some_txn());
  ASSERT_EQ(messages.size(), 1U);
  const Txn txn = read_of_gateway<Txn>(messages);
  EXPECT_EQ(txn.id, 7U);
  EXPECT_EQ(txn.patience_ns, 2'000'000U);
  ASSERT_EQ(txn.compares.size(), 2U);
  EXPECT_EQ(txn.compares[0].is, Compare::Is::less);
  EXPECT_EQ(txn.compares[1].what, Compare::What::create);
  EXPECT_EQ(txn.compares[0].revision, 3);
  ASSERT_EQ(txn.puts.size(), 1U);
  EXPECT_EQ(txn.puts[0].value, std::string("\0x", 2));
  EXPECT_EQ(txn.deletes, (std::vector<std::string>{"d"}));
  EXPECT_EQ(txn.else_get, (std::vector<std::string>{"e", "f"}));
}

TEST(ClusterWire, PatienceIsNeverRoundedToNothing) {
  Txn txn = some_txn();
  txn.patience_ns = 1;
  EXPECT_EQ(read_of_gateway<Txn>(messages_of(txn)).patience_ns, 1'000'000U);
}

TEST(ClusterWire, ALongTransactionTakesSeveralMessagesAndIsOneAgain) {
  Txn txn = some_txn();
  for (int i = 0; i < 15; ++i)
    txn.puts.push_back({.key = std::to_string(i), .value = std::string(kMaxValue, 'v')});
  ASSERT_EQ(misfit_of(txn), "");
  const auto messages = messages_of(txn);
  EXPECT_GT(messages.size(), 10U);
  for (const Message& message : messages) EXPECT_LE(message.size(), kMaxMessage);
  const Txn read = read_of_gateway<Txn>(messages);
  EXPECT_EQ(read.puts.size(), 16U);
  EXPECT_EQ(read.puts[15].value, txn.puts[15].value);
  EXPECT_EQ(read.else_get.size(), 2U);
}

TEST(ClusterWire, ATransactionThatTheStoreWouldNotTakeHasAMisfit) {
  Txn many = some_txn();
  many.deletes.assign(kMaxOperations, "x");
  EXPECT_NE(misfit_of(many), "");
  Txn large = some_txn();
  for (int i = 0; i < 20; ++i)
    large.puts.push_back({.key = "k", .value = std::string(kMaxValue, 'v')});
  EXPECT_NE(misfit_of(large), "");
  Txn value = some_txn();
  value.puts[0].value.assign(kMaxValue + 1, 'v');
  EXPECT_NE(misfit_of(value), "");
  Txn key = some_txn();
  key.else_get = {std::string(kMaxKey + 1, 'k')};
  EXPECT_NE(misfit_of(key), "");
  key.else_get = {""};
  EXPECT_NE(misfit_of(key), "");
}

TEST(ClusterWire, WhatTheStoreSaysArrivesAsItWasSent) {
  const auto state = read_of_store<StoreState>({message_of(StoreState{.reachable = true,
                                                                      .cluster_id = 5,
                                                                      .latency_ns = 6,
                                                                      .db_bytes = 7,
                                                                      .no_space = true,
                                                                      .endpoint = "https://a",
                                                                      .problem = "slow"})});
  EXPECT_TRUE(state.reachable && state.no_space);
  EXPECT_EQ(state.cluster_id + state.latency_ns + state.db_bytes, 18U);
  EXPECT_EQ(state.endpoint + state.problem, "https://aslow");
  EXPECT_EQ(read_of_store<ClusterSnapshot>({message_of(ClusterSnapshot{9})}).revision, 9);
  EXPECT_EQ(read_of_store<ClusterSynced>({message_of(ClusterSynced{9})}).revision, 9);
  TxnResult result{.id = 3, .outcome = Outcome::conflict, .revision = 8, .read = {}, .why = "w"};
  for (int i = 0; i < 5; ++i)
    result.read.push_back(
        {.key = "k", .value = std::string(kMaxValue, 'v'), .create = 1, .mod = 2});
  const auto messages = messages_of(result);
  EXPECT_EQ(messages.size(), 5U);
  const auto read = read_of_store<TxnResult>(messages);
  EXPECT_EQ(read.read.size(), 5U);
  EXPECT_EQ(read.outcome, Outcome::conflict);
  EXPECT_EQ(read.why, "w");
}

TEST(ClusterWire, ARevisionOfManyMessagesIsOneBatch) {
  Batch batch{.revision = 12, .entries = {}};
  for (int i = 0; i < 3000; ++i)
    batch.entries.push_back({.key = std::to_string(i), .value = std::string(100, 'v'), .mod = 12});
  batch.entries[5].gone = true;
  const auto messages = messages_of_batch(batch);
  EXPECT_GT(messages.size(), 3U);
  const auto read = read_of_store<Batch>(messages);
  EXPECT_EQ(read.revision, 12);
  ASSERT_EQ(read.entries.size(), 3000U);
  EXPECT_TRUE(read.entries[5].gone);
  EXPECT_FALSE(read.entries[6].gone);
}

TEST(ClusterWire, AMessageCarriesNoMoreEntriesThanThereIsCreditFor) {
  const Batch batch{.revision = 1, .entries = {entry("a"), entry("b"), entry("c")}};
  std::size_t next = 0;
  ReaderOfStore reader;
  auto read = reader.take(message_of(batch, next, 2, false));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(next, 2U);
  EXPECT_EQ(read->entries, 2U);
  EXPECT_FALSE(read->whole.has_value());
  read = reader.take(message_of(batch, next, 2, false));
  ASSERT_TRUE(read && read->whole);
  EXPECT_EQ(read->entries, 1U);
}

TEST(ClusterWire, WhatIsTooLongIsReplacedByWhatNobodyUnderstands) {
  const Entry value = bounded({.key = "k", .value = std::string(kMaxValue + 1, 'v'), .mod = 4});
  EXPECT_EQ(value.value, "\xff");
  EXPECT_EQ(value.key, "k");
  EXPECT_EQ(value.mod, 4);
  const std::string long_key(kMaxKey + 1, 'k');
  const Entry one = bounded(entry(long_key + "1"));
  const Entry two = bounded(entry(long_key + "2"));
  EXPECT_EQ(one.key.size(), kMaxKey);
  EXPECT_NE(one.key, two.key);
  EXPECT_EQ(one.key, bounded({.key = long_key + "1", .value = {}, .gone = true}).key);
  const Entry fits = bounded({.key = "k", .value = std::string(kMaxValue, 'v')});
  EXPECT_EQ(fits.value.size(), kMaxValue);
}

TEST(ClusterWire, AMessageThatEndsEarlyOrLateIsRefused) {
  StoreState state{};
  state.problem = "p";
  std::size_t next = 0;
  for (const Message& whole :
       {messages_of(some_txn())[0], message_of(Hello{"c", "g"}), message_of(Follow{{"/a"}}),
        message_of(Credit{1}), message_of(state), message_of(ClusterSnapshot{1}),
        message_of(ClusterSynced{1}),
        message_of(Batch{.revision = 1, .entries = {{.key = "a", .value = "v"}}}, next, 9, false),
        messages_of(TxnResult{.id = 1, .outcome = Outcome::full, .read = {}, .why = {}})[0]}) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(ReaderOfGateway().take({whole.data(), size}).has_value());
      EXPECT_FALSE(ReaderOfStore().take({whole.data(), size}).has_value());
    }
    const Message longer = whole + '\0';
    EXPECT_FALSE(ReaderOfGateway().take(longer).has_value());
    EXPECT_FALSE(ReaderOfStore().take(longer).has_value());
  }
}

TEST(ClusterWire, PartsOfTwoThingsAreNotMixed) {
  Txn txn = some_txn();
  for (int i = 0; i < 4; ++i)
    txn.puts.push_back({.key = "k", .value = std::string(kMaxValue, 'v')});
  const auto first = messages_of(txn);
  txn.id = 8;
  const auto second = messages_of(txn);
  ReaderOfGateway reader;
  ASSERT_TRUE(reader.take(first[0]).has_value());
  EXPECT_FALSE(reader.take(second[1]).has_value());
  ReaderOfGateway another;
  ASSERT_TRUE(another.take(first[0]).has_value());
  EXPECT_FALSE(another.take(message_of(Credit{1})).has_value());
}

TEST(ClusterWire, ARevisionOfTooManyEntriesIsRefused) {
  Batch batch{.revision = 1, .entries = std::vector<Entry>(1000, entry("k"))};
  ReaderOfStore reader;
  for (std::size_t sent = 0; sent + 1000 <= kMaxBatch; sent += 1000) {
    std::size_t next = 0;
    ASSERT_TRUE(reader.take(message_of(batch, next, kMaxBatch, true)).has_value());
    ASSERT_EQ(next, 1000U);
  }
  std::size_t next = 0;
  EXPECT_FALSE(reader.take(message_of(batch, next, kMaxBatch, true)).has_value());
}

TEST(ClusterWire, ANewSnapshotDropsARevisionThatWasNotWhole) {
  const Batch batch{.revision = 1, .entries = {entry("a")}};
  ReaderOfStore reader;
  std::size_t next = 0;
  ASSERT_TRUE(reader.take(message_of(batch, next, 1, true)).has_value());
  ASSERT_TRUE(reader.take(message_of(ClusterSnapshot{5})).has_value());
  next = 0;
  const auto read =
      reader.take(message_of(Batch{.revision = 5, .entries = {entry("b")}}, next, 1, false));
  ASSERT_TRUE(read && read->whole);
  EXPECT_EQ(std::get<Batch>(*read->whole).entries.size(), 1U);
}

}  // namespace
}  // namespace mlcca::cluster::wire
