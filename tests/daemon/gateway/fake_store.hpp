// SPDX-License-Identifier: BSD-2-Clause
// A store that gateways on benches share, without processes and time.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "daemon/outside/cluster_link.hpp"
#include "tests/core/cluster/store_stub.hpp"
#include "tests/daemon/gateway/fakes.hpp"

namespace mlcca::test {

using FakeStore = core::cluster::test::StoreStub;

/// The way of one gateway to it. What is said comes with deliver() alone.
class FakeLink final : public ClusterLink {
 public:
  FakeLink(FakeStore& store, FakeClock& clock) : store_(store), clock_(clock) {}

  void introduce(std::string, std::string gateway) override { name = std::move(gateway); }
  void send(const core::cluster::Txn& txn) override {
    sent.push_back(txn);
    sent_at_[txn.id] = clock_.monotonic;
  }
  void follow(std::vector<std::string>) override { synced_ = false; }
  /// Of another daemon, perhaps, with a connection of its own.
  void on_message(std::function<void(ClusterMessage)> call) override {
    call_ = std::move(call);
    said_up_ = synced_ = false;
    sent.clear();
    sent_at_.clear();
  }
  void wait(std::uint64_t ns) override {
    if (!deliver()) clock_.monotonic += ns;
  }

  /// True: something was said.
  bool deliver() {
    bool any = said_up_ != up || (!up && said_problem_ != problem) || said_full_ != full;
    if (any) {
      said_up_ = up;
      said_full_ = full;
      said_problem_ = problem;
      core::cluster::StoreState state{};
      state.reachable = up;
      state.no_space = full;
      if (!up) state.problem = problem;
      call_(state);
    }
    if (!up) {
      for (const auto& txn : std::exchange(sent, {})) {
        any = true;
        call_(core::cluster::TxnResult{
            .id = txn.id, .outcome = core::cluster::Outcome::unavailable, .why = problem});
      }
      synced_ = false;
      return any;
    }
    if (!synced_) {
      synced_ = any = true;
      call_(ClusterSnapshot{store_.revision});
      call_(store_.snapshot());
      call_(ClusterSynced{store_.revision});
      seen_ = store_.log.size();
    }
    for (; seen_ < store_.log.size(); ++seen_) {
      any = true;
      call_(store_.log[seen_]);
    }
    if (!sent.empty() && answers) {
      any = true;
      const auto txn = sent.front();
      sent.pop_front();
      call_(apply(txn));
    }
    return any;
  }

  bool up = true;
  std::string problem = "it is gone";  ///< while it is not up
  bool full = false;                   ///< it says so, and takes nothing but deletions
  bool answers = true;                 ///< to transactions
  /// What becomes of transactions whose answer is lost.
  enum class Lost : std::uint8_t { none, not_done, done } lost = Lost::none;
  /// When the latest transaction that was done was sent: its sender may use what is leased for one
  /// lease from then on.
  std::uint64_t leased_from = 0;
  /// The store gives all it has again, as after a compaction.
  void read_again() { synced_ = false; }
  std::string name;
  std::deque<core::cluster::Txn> sent;

 private:
  core::cluster::TxnResult apply(const core::cluster::Txn& txn) {
    core::cluster::TxnResult result{
        .id = txn.id, .outcome = core::cluster::Outcome::unsure, .why = "no answer"};
    const std::uint64_t at = sent_at_[txn.id];
    sent_at_.erase(txn.id);
    if (lost == Lost::not_done) return result;
    if (full && !txn.puts.empty()) {
      result.outcome = core::cluster::Outcome::full;
      result.why = "database space exceeded";
      return result;
    }
    auto done = store_.apply(txn);
    if (done.outcome == core::cluster::Outcome::committed) leased_from = at;
    return lost == Lost::none ? done : result;
  }

  FakeStore& store_;
  FakeClock& clock_;
  std::function<void(ClusterMessage)> call_;
  bool said_up_ = false, said_full_ = false, synced_ = false;
  std::string said_problem_;
  std::map<std::uint64_t, std::uint64_t> sent_at_;  ///< by transaction: CLOCK_MONOTONIC ns
  std::size_t seen_ = 0;
};

}  // namespace mlcca::test
