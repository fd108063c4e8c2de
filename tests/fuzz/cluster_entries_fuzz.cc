// SPDX-License-Identifier: BSD-2-Clause
// Any entries in the store that gateways share, as whoever may write there could leave them. A
// member of the cluster reads them with the codec of the daemon, and goes on.
//
// An input is a list of steps. The first octet of a step says what it is; a name and a value have
// their length in two octets in front, the lower one first:
//   w NAME VALUE   somebody writes this value under this name
//   d NAME         somebody deletes it
//   r N, e N       this gateway reserves something for its admission N, or gives it back
//   t N            N quarters of a second pass
//   s              the member reads everything again
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "core/cluster/member.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "tests/core/cluster/parts.hpp"
#include "tests/core/cluster/store_stub.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca;
using namespace mlcca::core::cluster;
using fuzz::demand;

constexpr std::size_t kSelf = 0;
constexpr Value kQuarter = 250'000'000;  // ns
constexpr int kMostRounds = 64;          // in which a member may answer what it has read

core::System described() {
  core::System system;
  for (const char* name : {"b", "m"}) system.networks.emplace_back().name = name;
  system.networks[1].mesh.emplace().nodes.resize(3);
  for (const char* name : {"g", "h", "i/j"}) {
    core::Gateway& gateway = system.gateways.emplace_back();
    gateway.name = name;
    for (std::size_t n = 0; n < 2; ++n) gateway.ports.emplace_back().network = n;
  }
  system.publishers.resize(4);
  return system;
}

Digest in_use() {
  Digest digest{};
  digest.fill(7);
  return digest;
}

/// Takes what it asks for from the front of an input, which may end anywhere.
class Steps {
 public:
  explicit Steps(std::string_view input) : rest_(input) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  std::uint8_t octet() {
    if (rest_.empty()) return 0;
    const auto value = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    return value;
  }
  std::string text() {
    const std::size_t low = octet();
    const std::size_t length = std::min(low | std::size_t{octet()} << 8U, rest_.size());
    std::string value(rest_.substr(0, length));
    rest_.remove_prefix(length);
    return value;
  }

 private:
  std::string_view rest_;
};

class Scene {
 public:
  Scene() {
    store_.write({{.key = keys_->current(),
                   .value = codec_.write(
                       Current{.generation = 1, .digest = in_use(), .open = true, .waits = {}})}});
    member_.on_state({.reachable = true, .endpoint = {}, .problem = {}}, now_);
    read_all();
  }

  void play(std::string_view input) {
    for (Steps steps(input); !steps.empty();) {
      step(steps);
      answer();
      look();
    }
  }

 private:
  void step(Steps& steps) {
    switch (steps.octet()) {
      case 'w': {
        const std::string name = steps.text();
        store_.write({{.key = "p/" + name, .value = steps.text()}});
        break;
      }
      case 'd':
        store_.write({}, {"p/" + steps.text()});
        break;
      case 'r': {
        const std::uint64_t id = steps.octet();
        if (id == 0 || !member_.why_not(now_).empty() || member_.knows(id)) break;
        member_.reserve({.id = id,
                         .footprint = {.parts = {test::part_of(0, 1)}, .gateways = {id % 3}},
                         .admission = "request"},
                        now_);
        break;
      }
      case 'e':
        member_.release(steps.octet(), now_);
        break;
      case 't':
        for (int left = steps.octet() % 64; left > 0; --left) {
          now_ += kQuarter;
          member_.on_time(now_);
          answer();
        }
        break;
      case 's':
        read_all();
        break;
      default:
        break;
    }
  }

  void read_all() {
    member_.on_snapshot_begin(store_.revision, now_);
    member_.on_batch(store_.snapshot(), now_);
    member_.on_snapshot_end(now_);
    seen_ = store_.log.size();
    answer();
  }

  /// As the daemon does: what is new is read, events are handled, transactions are sent.
  void answer() {
    for (int round = 0; round < kMostRounds; ++round) {
      while (seen_ < store_.log.size()) member_.on_batch(store_.log[seen_++], now_);
      for (const Event& event : member_.take_events()) handle(event);
      member_.applied(member_.view().revision());
      const auto txns = member_.take_txns(now_);
      if (txns.empty() && seen_ == store_.log.size()) return;
      for (const Txn& txn : txns) {
        check(txn);
        member_.on_result(store_.apply(txn), now_);
      }
    }
    demand(false, "it writes without end at one and the same time");
  }

  void handle(const Event& event) {
    if (const auto* withdrawn = std::get_if<Withdrawn>(&event)) {
      member_.release(withdrawn->id, now_);
    } else if (const auto* conflict = std::get_if<Conflict>(&event)) {
      member_.release(conflict->id, now_);
    } else if (const auto* found = std::get_if<Found>(&event)) {
      member_.release(found->id, now_);
    } else if (const auto* adopt = std::get_if<Adopt>(&event)) {
      if (const auto asked = mlcca::cluster::asked_in(adopt->admission))
        demand(asked->size() <= mlcca::cluster::StoredRequest::kMostRequests, "too many requests");
      member_.vote(adopt->origin, {.ok = true, .hop = {}, .reason = {}}, now_);
    } else if (const auto* judge = std::get_if<Judge>(&event)) {
      member_.vote_rollout(judge->digest, false, "no");
    }
  }

  /// A gateway writes in its own name only.
  void check(const Txn& txn) const {
    for (const Put& put : txn.puts) {
      const auto key = keys_->parse(put.key);
      demand(key.has_value(), "it writes under a name that it does not understand");
      const bool named = key->kind == Key::Kind::member || key->kind == Key::Kind::reservation ||
                         key->kind == Key::Kind::asked || key->kind == Key::Kind::vote ||
                         key->kind == Key::Kind::rollout_vote;
      demand(!named || key->gateway == kSelf, "it writes in the name of another gateway");
    }
  }

  void look() const {
    const View& view = member_.view();
    for (std::size_t n = 0; n < 2; ++n) {
      (void)view.of_others(n);
      (void)view.made_for(n);
    }
    demand(member_.valid_until() <= now_ + core::cluster::kMostLease,
           "it would send for longer than a lease lasts");
  }

  const core::System system_ = described();
  const mlcca::cluster::RecordCodec codec_{system_, in_use()};
  const std::shared_ptr<const Keys> keys_ = std::make_shared<Keys>(system_, "p/");
  test::StoreStub store_;
  std::size_t seen_ = 0;
  Value now_ = 1'000'000'000'000;
  Member member_{
      keys_, codec_,
      Member::Identity{
          .gateway = kSelf, .digest = in_use(), .session = 1, .lease = 40 * kQuarter, .was = {}}};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Scene().play({reinterpret_cast<const char*>(data), size});
  return 0;
}
