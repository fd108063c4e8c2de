// SPDX-License-Identifier: BSD-2-Clause
// A gateway that settles one change after the other has what it would have if it began now, with
// what is granted and reserved: each settlement leaves out only what a change cannot concern.
#include <gtest/gtest.h>

#include <set>

#include "tests/core/shared/random_systems.hpp"

namespace mlcca::core::testing {
namespace {

/// A delivery as it is decided, and over which places it goes.
using Decided = std::tuple<Delivery, bool, Route>;

struct Found {
  std::vector<std::size_t> sets;  ///< of each channel; of one without a grant it says nothing
  std::vector<std::vector<Decided>> deliveries;
  std::vector<std::vector<can::Message>> messages;  ///< of each network
  std::vector<Value> reserved;                      ///< of each resource
  std::vector<std::vector<Value>> medium_time;
};

Found found(const State& state) {
  Found out;
  for (const Decision& decision : state.decisions()) {
    out.sets.push_back(decision.granted == 0 ? 0 : decision.set);
    auto& all = out.deliveries.emplace_back();
    for (const Verdict& v : decision.verdicts)
      all.emplace_back(state.delivery_of(v), v.granted, v.granted ? v.route : Route{});
    std::ranges::sort(all);
  }
  const System& system = state.system();
  for (std::size_t r = 0; r < system.resources(); ++r)
    out.reserved.push_back(state.ledger().reserved(r));
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    out.messages.emplace_back();
    if (state.ledger().schedule(n) != nullptr) out.messages.back() = messages_on(state, n);
    auto& times = out.medium_time.emplace_back();
    if (const auto& view = state.world().meshes[n])
      for (std::size_t d = 0; d < view->domains().count(); ++d)
        times.push_back(state.ledger().medium_time(n, d));
  }
  return out;
}

std::string words(const std::vector<can::Message>& messages) {
  std::string out;
  for (const can::Message& m : messages)
    out += "  " + std::to_string(m.priority) + " each " + std::to_string(m.period / kMs) +
           " ms within " + std::to_string(m.deadline / kMs) + " ms\n";
  return out;
}

/// As after a start, with the same world, and with what is granted now.
std::unique_ptr<State> begun_now(const System& system, const State& like) {
  auto fresh = std::make_unique<State>(system);
  const World& world = like.world();
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    fresh->set_condition(n, world.conditions[n]);
    if (world.meshes[n]) fresh->set_graph(n, world.meshes[n]->graph);
    fresh->set_foreign(n, world.foreign[n]);
  }
  for (std::size_t g = 0; g < system.gateways.size(); ++g) fresh->set_failed(g, world.failed[g]);
  for (std::size_t c = 0; c < system.channels.size(); ++c)
    fresh->set_withdrawn(c, like.withdrawn(c));
  fresh->set_permits(like.permits());
  for (const auto& [id, channel] : like.admissions()) fresh->restore(like.admission(id));
  std::map<std::size_t, Grants> grants;
  for (std::size_t c = 0; c < system.channels.size(); ++c) grants.emplace(c, like.grants(c));
  fresh->decide(grants);
  return fresh;
}

/// The first gateway of two, among changes of all kinds.
class History {
 public:
  explicit History(unsigned seed) : random_(seed), pair_(system_of(random_, seed)) {}

  void step() {
    for (std::size_t changes = 1 + below(random_, 3); changes > 0; --changes) change();
    read();
  }

  /// Where not all that is promised fits, what counts of it depends on the order in which it came.
  void expect_as_begun_now() {
    const State& state = us().state;
    const auto fresh = begun_now(pair_.system, state);
    for (std::size_t n = 0; n < pair_.system.networks.size(); ++n)
      if (!fresh->ledger().counts_all(n)) return;
    ++compared;
    const Found ours = found(state);
    const Found theirs = found(*fresh);
    for (std::size_t c = 0; c < ours.sets.size(); ++c) {
      EXPECT_EQ(ours.sets[c], theirs.sets[c]) << "channel " << c;
      EXPECT_EQ(ours.deliveries[c].size(), theirs.deliveries[c].size()) << "channel " << c;
      EXPECT_TRUE(ours.deliveries[c] == theirs.deliveries[c])
          << "channel " << c << ": " << granted(state, c) << " and " << granted(*fresh, c);
    }
    EXPECT_EQ(ours.reserved, theirs.reserved);
    EXPECT_EQ(ours.medium_time, theirs.medium_time);
    for (std::size_t n = 0; n < ours.messages.size(); ++n)
      EXPECT_TRUE(ours.messages[n] == theirs.messages[n]) << "network " << n << ":\n"
                                                          << words(ours.messages[n]) << "and\n"
                                                          << words(theirs.messages[n]);
  }

  std::size_t compared = 0;  ///< steps
  std::size_t unfit = 0;     ///< admissions that were reserved, and did not fit when they came
  std::map<std::string, std::size_t> kinds;  ///< how often there was a change of a kind

 private:
  static System system_of(Random& random, unsigned seed) {
    System system = random_system(random, seed % 3 != 0);
    if (chance(random, 30)) system.channels[below(random, kChannels)].importance = 1;
    return system;
  }
  Peer& us() { return pair_[0]; }

  void read() {
    State& state = us().state;
    for (std::size_t n = 0; n < pair_.system.networks.size(); ++n) {
      if (!state.world().shared[n]) continue;
      cluster::Foreign foreign = pair_.store.without(0, n);
      for (const auto* const of_ours : {&taken_back_, &unused_, &leaving_})
        for (const auto& [number, footprint] : *of_ours)
          for (const cluster::Part& part : footprint.parts)
            if (part.network == n) cluster::add(foreign, part, 0);
      state.set_foreign(n, std::move(foreign));
    }
    static_cast<void>(state.settle());
  }

  void change() {
    const std::size_t what = below(random_, 100);
    if (what < 25) return admit_here();
    if (what < 40) return admit_there();
    if (what < 47) return end_here();
    if (what < 50) return take_back();
    if (what < 60) return end_there();
    if (what < 68) return give_back();
    if (what < 76) return change_there();
    if (what < 82) return open_or_close();
    if (what < 86) return withdraw();
    if (what < 90) return wait_or_come_back();
    if (what < 96) return change_network();
    fail_there();
  }

  Admission wanted(std::size_t gateway) {
    const AdmissionId id = next_++;
    return chance(random_, 30) ? late_subscriber(random_, pair_.system, gateway, id)
                               : random_admission(random_, pair_.system, gateway, id);
  }

  void admit_here() {
    read();
    const Admission a = wanted(0);
    const auto footprint = us().ask(a);
    if (!footprint) return;
    us().permits.put(a.id, *footprint);
    // Sometimes it is not in force yet when the next change comes.
    read();
    Proposal p = us().state.propose(a);
    if (!p.fit()) {
      us().permits.erase(a.id);
      ++unfit;
      return;
    }
    std::move(p).accept();
    held_.emplace(a.id, *footprint);
    ++kinds["admitted here"];
  }

  void admit_there() {
    const Admission a = wanted(1);
    if (pair_[1].admit(a)) ++kinds["admitted there"];
  }

  template <class Map>
  auto any_of(Map& map) {
    return std::next(map.begin(), static_cast<std::ptrdiff_t>(below(random_, map.size())));
  }

  /// The store has it until it is given back.
  void end_here() {
    if (chance(random_, 30) && !taken_back_.empty()) {
      const auto it = any_of(taken_back_);
      us().state.remove(it->first);
      leaving_.insert(taken_back_.extract(it));
    } else if (!held_.empty()) {
      const auto it = any_of(held_);
      us().state.remove(it->first);
      unused_.insert(held_.extract(it));
    } else {
      return;
    }
    ++kinds["ended here"];
  }

  /// It may not be used any more, and whoever asked for it is still there.
  void take_back() {
    if (held_.empty()) return;
    const auto it = any_of(held_);
    us().permits.erase(it->first);
    taken_back_.insert(held_.extract(it));
    ++kinds["taken back"];
  }

  /// What waits for another gateway is out of the state, and comes back with what is reserved.
  void wait_or_come_back() {
    if (!waiting_.empty() && chance(random_, 50)) {
      const auto it = any_of(waiting_);
      us().state.restore(it->second);
      held_.insert(unused_.extract(it->first));
      waiting_.erase(it);
    } else if (!held_.empty()) {
      const auto it = any_of(held_);
      waiting_.emplace(it->first, us().state.admission(it->first));
      us().state.remove(it->first);
      unused_.insert(held_.extract(it));
    } else {
      return;
    }
    ++kinds["waits or comes back"];
  }

  void give_back() {
    if (!leaving_.empty() && chance(random_, 50)) {
      leaving_.erase(any_of(leaving_));
    } else if (!unused_.empty()) {
      const auto it = any_of(unused_);
      us().permits.erase(it->first);
      waiting_.erase(it->first);
      leaving_.insert(unused_.extract(it));
    } else {
      return;
    }
    ++kinds["given back"];
  }

  void end_there() {
    if (pair_.store.entries.empty()) return;
    const AdmissionId id = any_of(pair_.store.entries)->first;
    if (pair_[1].state.admissions().contains(id)) pair_[1].release(id);
    pair_.store.entries.erase(id);
    ++kinds["ended there"];
  }

  /// More or less than before, also more than fits.
  void change_there() {
    if (pair_.store.entries.empty()) return;
    auto& entry = any_of(pair_.store.entries)->second;
    const std::size_t times = 1 + below(random_, 6);
    for (cluster::Part& part : entry.footprint.parts) {
      for (auto& rate : part.rates) rate.bytes_per_second = rate.bytes_per_second * times / 2;
      for (auto& path : part.paths) path.bytes_per_second = path.bytes_per_second * times / 2;
      for (auto& bus : part.bus) bus.message.period = bus.message.period * 2 / times;
    }
    ++kinds["changed there"];
  }

  void open_or_close() {
    Permits& permits = us().permits;
    if (permits.is_open())
      permits.close(chance(random_, 30));
    else
      permits.open();
    ++kinds["opened or closed"];
  }

  void withdraw() {
    const std::size_t c = below(random_, kChannels);
    us().state.set_withdrawn(c, !us().state.withdrawn(c));
    ++kinds["withdrawn"];
  }

  void change_network() {
    Condition condition;
    const std::size_t n = below(random_, pair_.system.networks.size());
    const bool can = pair_.system.networks[n].kind == NetworkKind::can;
    if (chance(random_, 20)) condition.available = false;
    if (can && chance(random_, 50)) condition.background = 200'000;
    us().state.set_condition(n, condition);
    if (n == kAir) {
      mesh::Graph graph = described_world(pair_.system).meshes[kAir]->graph;
      for (mesh::Link& link : graph.links)
        link.busy = static_cast<Value>(chance(random_, 50) ? 0 : 400'000);
      us().state.set_graph(kAir, graph);
    }
    ++kinds["network changed"];
  }

  void fail_there() {
    us().state.set_failed(1, !us().state.world().failed[1]);
    ++kinds["failed or back"];
  }

  Random random_;
  Pair pair_;
  AdmissionId next_ = 1;
  // What this gateway has reserved, by what may be used of it, and whether the admission is there.
  std::map<AdmissionId, cluster::Footprint> held_;        ///< both
  std::map<AdmissionId, cluster::Footprint> taken_back_;  ///< the admission alone
  std::map<AdmissionId, cluster::Footprint> unused_;      ///< without the admission
  std::map<AdmissionId, cluster::Footprint> leaving_;     ///< neither
  std::map<AdmissionId, Admission> waiting_;              ///< of the unused ones, those that wait
};

class IncrementalTest : public ::testing::TestWithParam<unsigned> {
 protected:
  /// Histories in which little happens, or in which nothing could be compared, would prove little.
  static void TearDownTestSuite() {
    if (histories < 100) return;
    EXPECT_GE(compared, steps / 2);
    EXPECT_EQ(kinds.size(), 12U);
    for (const auto& [kind, times] : kinds) EXPECT_GE(times, 100U) << kind;
  }
  static inline std::size_t histories = 0, steps = 0, compared = 0;
  static inline std::map<std::string, std::size_t> kinds;
};

TEST_P(IncrementalTest, EachStepLeavesWhatAStartWouldDecide) {
  History history(GetParam());
  for (int i = 0; i < 60; ++i) {
    history.step();
    history.expect_as_begun_now();
    ++steps;
    if (HasFailure()) FAIL() << "at step " << i;
  }
  ++histories;
  compared += history.compared;
  for (const auto& [kind, times] : history.kinds) kinds[kind] += times;
}

INSTANTIATE_TEST_SUITE_P(Seeds, IncrementalTest, ::testing::Range(1U, 101U));

}  // namespace
}  // namespace mlcca::core::testing
