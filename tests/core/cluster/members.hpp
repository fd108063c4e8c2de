// SPDX-License-Identifier: BSD-2-Clause
// A few members on one store that answers at once, unless a test says otherwise.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/lease.hpp"
#include "core/cluster/member.hpp"
#include "tests/core/cluster/codec.hpp"
#include "tests/core/cluster/store_stub.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

class ClusterMember : public testing::Test {
 protected:
  static constexpr Value kSecond = 1'000'000'000;
  static constexpr Value kTen = 10 * kSecond;

  struct Node {
    std::optional<Member> member;
    std::vector<Event> events;
    std::size_t seen = 0;
    bool cut_off = false;
    std::vector<Txn> lost;  ///< while it was cut off
    template <class T>
    std::vector<T> take() {
      std::vector<T> all;
      for (const Event& event : events)
        if (const T* is = std::get_if<T>(&event)) all.push_back(*is);
      std::erase_if(events, [](const Event& event) { return std::holds_alternative<T>(event); });
      return all;
    }
  };

  void start(std::size_t g, Journalled was = {}, std::uint8_t description = 1) {
    nodes.resize(std::max(nodes.size(), g + 1));
    nodes[g] = Node{};
    nodes[g].member.emplace(keys, codec,
                            Member::Identity{.gateway = g,
                                             .digest = TextCodec::digest(description),
                                             .session = ++sessions,
                                             .lease = kTen,
                                             .was = was});
    Member& member = *nodes[g].member;
    member.on_state({.reachable = true, .endpoint = {}, .problem = {}}, now);
    read_all(g);
    run();
  }
  /// The store is restored from what it had when the first gateway began, which reads that.
  void go_back() {
    const StoreStub backup = store;
    pass(kTen);
    store = backup;
    read_all(0);
    run();
  }
  void read_all(std::size_t g) {
    Member& member = *nodes[g].member;
    member.on_snapshot_begin(store.revision, now);
    member.on_batch(store.snapshot(), now);
    member.on_snapshot_end(now);
    nodes[g].seen = store.log.size();
  }
  void in_force(std::uint8_t description) {
    store.write({{.key = keys->current(),
                  .value = codec.write(Current{.generation = 1,
                                               .digest = TextCodec::digest(description),
                                               .open = true,
                                               .waits = {}})}});
  }
  /// Until nothing is to be done at this time.
  void run() {
    for (bool more = true; more;) {
      more = false;
      for (Node& node : nodes) more = (node.member && turn(node)) || more;
    }
  }
  bool turn(Node& node) {
    bool more = false;
    while (!node.cut_off && node.seen < store.log.size()) {
      node.member->on_batch(store.log[node.seen++], now);
      more = true;
    }
    for (Event& event : node.member->take_events()) node.events.push_back(std::move(event));
    node.member->applied(node.member->view().revision());
    for (Txn& txn : node.member->take_txns(now)) {
      more = true;
      if (node.cut_off)
        node.lost.push_back(std::move(txn));
      else
        node.member->on_result(store.apply(txn), now);
    }
    return more;
  }
  void pass(Value time) {
    const Value end = now + time;
    while (now < end) {
      now = std::min(end, now + (kSecond / 4));
      for (Node& node : nodes)
        if (node.member) node.member->on_time(now);
      run();
    }
  }
  /// Time passes for the first gateway, which is cut off: the store answers it that it is full.
  void pass_while_full(Value time) {
    for (const Value end = now + time; now < end;) {
      turn(nodes[0]);
      for (const Txn& txn : std::exchange(nodes[0].lost, {}))
        at(0).on_result({.id = txn.id, .outcome = Outcome::full, .why = "no space"}, now);
      now += kSecond / 4;
      at(0).on_time(now);
    }
  }
  Member& at(std::size_t g) { return *nodes[g].member; }
  Wanted unit(std::uint64_t id, std::vector<std::size_t> through = {}) {
    return {.id = id,
            .footprint = {.parts = {part_of(0, 1)}, .gateways = std::move(through)},
            .admission = "request"};
  }

  TextCodec codec;
  std::shared_ptr<const Keys> keys = keys_of(3);
  StoreStub store;
  std::vector<Node> nodes;
  Value now = 1000 * kSecond;
  std::uint64_t sessions = 0;
};

}  // namespace mlcca::core::cluster::test
