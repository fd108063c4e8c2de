// SPDX-License-Identifier: BSD-2-Clause
// Checks the protocol of a cluster over all interleavings of small cases: real members and views,
// with a store, clocks and messages that do anything they may. CLUSTER_FAULTS=2 lets each fault
// happen once more.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/hash.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {
namespace {

struct HashOfPair {
  std::size_t operator()(const std::pair<std::uint64_t, std::uint64_t>& v) const { return v.first; }
};

/// Explores the states of a scenario. Neighbouring states are tried in random order, so that a part
/// of the states is a sample of all.
class Checker {
 public:
  Checker(const Scenario& scenario, std::size_t most, std::size_t recover_each,
          std::uint64_t seed = 0)
      : scenario_(scenario), most_(most), recover_each_(recover_each), seed_(seed) {}

  /// The broken promise with the steps that lead to it; empty if there is none.
  std::string run() {
    explore(World(scenario_, keys_of(scenario_.gateways)));
    return found_;
  }
  [[nodiscard]] std::size_t states() const { return seen_.size(); }
  [[nodiscard]] bool all() const { return seen_.size() < most_; }

 private:
  void explore(const World& world) {
    if (!world.broken().empty()) return report(world.broken());
    if (path_.size() > kLongestPath) return report("it never comes to rest");
    const auto print = world.fingerprint();
    if (seen_.size() >= most_ || !seen_.insert(print).second) return;
    if (print.second % recover_each_ == 0) {
      World well = world;
      well.recover();
      if (!well.broken().empty()) return report("when all is well again: " + well.broken());
    }
    auto steps = world.steps(true);
    for (std::size_t n = steps.size(), random = hash_with(print.first ^ seed_, 1) >> 24U; n > 1;
         --n, random /= n + 1)
      std::swap(steps[n - 1], steps[random % n]);
    for (const Step& step : steps) {
      World next = world;
      path_.push_back(step);
      next.take(step);
      explore(next);
      path_.pop_back();
      if (!found_.empty()) return;
    }
  }
  void report(const std::string& what) {
    found_ = what + ":";
    for (const Step& step : path_) found_ += "\n  " + text_of(step);
  }

  static constexpr std::size_t kLongestPath = 500;
  const Scenario& scenario_;
  std::size_t most_, recover_each_;
  std::uint64_t seed_;  ///< of the order in which steps are tried
  std::unordered_set<std::pair<std::uint64_t, std::uint64_t>, HashOfPair> seen_;
  std::vector<Step> path_;
  std::string found_;
};

constexpr int kSlow = -1000, kFast = 1000;

std::vector<Scenario> scenarios() {
  const std::vector<int> worst = {kSlow, kFast};
  return {
      {.name = "plain", .steps = 2, .wants = {2, 1}, .releases = 1},
      {.name = "waits", .steps = 4, .wants = {2, 1}, .releases = 1, .waits = true},
      {.name = "waits, dead",
       .clock_ppm = {kFast, kSlow},
       .steps = 8,
       .crashes = 1,
       .waits = true,
       .faulty = {1}},
      {.name = "late", .steps = 2, .late = 1, .faulty = {0, 1}},
      {.name = "lost", .steps = 2, .lost = 1, .faulty = {0, 1}},
      {.name = "twice", .steps = 1, .twice = 1, .faulty = {0, 1}},
      {.name = "released", .steps = 3, .releases = 1, .late = 1},
      {.name = "dead", .clock_ppm = {kFast, kSlow}, .steps = 8, .crashes = 1, .faulty = {1}},
      {.name = "dead and late", .clock_ppm = worst, .steps = 8, .late = 1, .crashes = 1},
      {.name = "paused", .clock_ppm = worst, .steps = 8, .pauses = 1},
      {.name = "stalled", .clock_ppm = worst, .steps = 8, .stalls = 1, .crashes = 1, .faulty = {1}},
      {.name = "fenced", .clock_ppm = worst, .steps = 8, .fences = 1},
      {.name = "fenced and blind", .clock_ppm = worst, .steps = 8, .stalls = 1, .fences = 1},
      {.name = "way late",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 5,
       .way = true,
       .wants = {1, 0, 1},
       .late = 1,
       .faulty = {1}},
      {.name = "compacted",
       .clock_ppm = worst,
       .steps = 8,
       .crashes = 1,
       .compactions = 1,
       .faulty = {0, 1}},
      {.name = "outage", .clock_ppm = worst, .steps = 8, .outages = 1},
      {.name = "restored", .clock_ppm = worst, .steps = 9, .outages = 1, .restores = 1},
      {.name = "elected, restored",
       .clock_ppm = worst,
       .steps = 9,
       .elect = true,
       .wants = {0, 0},
       .outages = 1,
       .restores = 1},
      {.name = "drained", .steps = 4, .drains = 1},
      {.name = "way",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 2,
       .way = true,
       .wants = {1, 0, 1}},
      {.name = "way ended",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 4,
       .way = true,
       .wants = {1, 0, 1},
       .releases = 1,
       .stalls = 1,
       .faulty = {1}},
      {.name = "way refused",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 3,
       .way = true,
       .wants = {1, 0, 1},
       .refusals = 1},
      {.name = "way dead",
       .gateways = 3,
       .clock_ppm = {kSlow, kSlow, kFast},
       .steps = 8,
       .way = true,
       .wants = {1, 0, 1},
       .crashes = 1},
      {.name = "on behalf",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 2,
       .behalf = true,
       .wants = {0, 1, 1}},
      {.name = "on behalf ended",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 4,
       .behalf = true,
       .wants = {0, 1, 1},
       .releases = 1,
       .stalls = 1,
       .refusals = 1,
       .faulty = {0, 1}},
      {.name = "on behalf, dead",
       .gateways = 3,
       .clock_ppm = {kSlow, kSlow, kFast},
       .steps = 8,
       .behalf = true,
       .wants = {0, 1, 1},
       .crashes = 1,
       .faulty = {0, 1}},
      {.name = "on behalf, fenced",
       .clock_ppm = worst,
       .steps = 8,
       .behalf = true,
       .wants = {0, 1},
       .fences = 1,
       .faulty = {0, 1}},
      {.name = "on behalf, late",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 5,
       .behalf = true,
       .wants = {0, 1, 1},
       .late = 1,
       .lost = 1,
       .faulty = {0, 1}},
      {.name = "refused for a while",
       .steps = 4,
       .behalf = true,
       .subscribers = 1,
       .wants = {0, 1},
       .refusals = 2},
      {.name = "two subscribers",
       .steps = 3,
       .behalf = true,
       .subscribers = 2,
       .wants = {0, 2},
       .refusals = 1},
      {.name = "two, publisher ends",
       .steps = 3,
       .behalf = true,
       .subscribers = 2,
       .wants = {0, 2},
       .releases = 1,
       .refusals = 1},
      {.name = "two, dead",
       .clock_ppm = worst,
       .steps = 8,
       .behalf = true,
       .subscribers = 2,
       .wants = {0, 2},
       .crashes = 1,
       .faulty = {0, 1}},
      {.name = "two, fenced",
       .clock_ppm = worst,
       .steps = 8,
       .behalf = true,
       .subscribers = 2,
       .wants = {0, 2},
       .fences = 1,
       .refusals = 1,
       .faulty = {0, 1}},
      {.name = "two, late",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 5,
       .behalf = true,
       .subscribers = 2,
       .wants = {0, 2, 1},
       .late = 1,
       .lost = 1,
       .refusals = 1,
       .faulty = {0, 1}},
      {.name = "elected",
       .clock_ppm = worst,
       .steps = 8,
       .elect = true,
       .wants = {0, 0},
       .crashes = 1},
      {.name = "elected late",
       .clock_ppm = worst,
       .steps = 7,
       .elect = true,
       .wants = {0, 0},
       .stalls = 1,
       .pauses = 1},
      {.name = "elected drained",
       .steps = 3,
       .elect = true,
       .wants = {0, 0},
       .stalls = 1,
       .drains = 1,
       .faulty = {0, 1}},
  };
}

std::size_t from_environment(const char* name, std::size_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

TEST(ClusterChecker, NothingIsBroken) {
  const std::size_t most = from_environment("CLUSTER_STATES", 10'000);
  const char* only = std::getenv("CLUSTER_SCENARIO");
  std::size_t states = 0;
  for (const Scenario& scenario : scenarios()) {
    if (only != nullptr && scenario.name != only) continue;
    Checker checker(scenario, most, 64);
    const std::string found = checker.run();
    if (!found.empty()) ADD_FAILURE() << scenario.name << ": " << found;
    printf("%-16s %8zu states%s\n", scenario.name.c_str(), checker.states(),
           checker.all() ? ", all of them" : "");
    fflush(stdout);
    states += checker.states();
  }
  printf("%zu states\n", states);
}

struct Wrong {
  const char* name = nullptr;
  Scenario scenario;
};

/// Each wrong protocol with the smallest scenario that shows it.
std::vector<Wrong> wrong_protocols() {
  Scenario two{.clock_ppm = {kFast, kSlow}, .steps = 8, .wants = {0, 1}, .faulty = {1}};
  Scenario way{.gateways = 3, .clock_ppm = {0, 0, 0}, .steps = 5, .way = true, .wants = {1, 0, 0}};
  const auto with = [](Scenario scenario, Mutant mutant) {
    scenario.mutant = mutant;
    return scenario;
  };
  Scenario late = two, paused = two, crashed = two, blind = two;
  late.late = 2;
  paused.pauses = 1;
  crashed.crashes = 1;
  blind.stalls = blind.fences = 1;
  Scenario ended = way;
  const Scenario slow_way{.steps = 4, .way = true, .wants = {1, 0}, .crashes = 1, .faulty = {1}};
  ended.releases = ended.steps = 1;
  const Scenario behalf{.gateways = 3,
                        .clock_ppm = {0, 0, 0},
                        .steps = 4,
                        .behalf = true,
                        .wants = {0, 1, 1},
                        .releases = 1};
  const Scenario refused{
      .steps = 4, .behalf = true, .subscribers = 1, .wants = {0, 1}, .refusals = 1};
  const Scenario served{
      .steps = 2, .behalf = true, .subscribers = 2, .wants = {0, 2}, .refusals = 1};
  return {
      {.name = "EndedByAPassingRefusal",
       .scenario = with(refused, Mutant::ended_by_a_passing_refusal)},
      {.name = "ServedWithoutAVote", .scenario = with(served, Mutant::served_without_a_vote)},
      {.name = "RenewedWithoutQuorum", .scenario = with(late, Mutant::renewed_without_quorum)},
      {.name = "ValidFromAnswer", .scenario = with(paused, Mutant::valid_from_answer)},
      {.name = "ClockErrorIgnored", .scenario = with(crashed, Mutant::clock_error_ignored)},
      {.name = "FenceWithoutCompare", .scenario = with(paused, Mutant::fence_without_compare)},
      {.name = "FreedOnFenceAlone",
       .scenario = {.steps = 3, .fences = 1, .mutant = Mutant::freed_on_fence_alone}},
      {.name = "GrantWithoutVersion",
       .scenario = {.steps = 1, .mutant = Mutant::grant_without_version}},
      {.name = "NoFenceCompare", .scenario = with(blind, Mutant::no_fence_compare)},
      {.name = "NoChain",
       .scenario =
           {.steps = 1, .wants = {1, 0}, .late = 1, .crashes = 1, .mutant = Mutant::no_chain}},
      {.name = "OpenBeforeVotes", .scenario = with(slow_way, Mutant::open_before_votes)},
      {.name = "EndedAtOnce", .scenario = with(ended, Mutant::ended_at_once)},
      {.name = "AgreedAtOnce", .scenario = with(behalf, Mutant::agreed_at_once)},
      {.name = "KeptAfterItsEnd", .scenario = with(behalf, Mutant::kept_after_its_end)},
      {.name = "ActiveWithoutAsking",
       .scenario = {.clock_ppm = {kFast, kSlow},
                    .steps = 7,
                    .elect = true,
                    .wants = {0, 0},
                    .stalls = 1,
                    .crashes = 1,
                    .mutant = Mutant::active_without_asking}},
  };
}

/// Many short searches in different orders find a fault sooner than a long search in one order.
TEST(ClusterChecker, FindsEveryWrongProtocol) {
  constexpr std::size_t kStates = 2'000, kOrders = 100;
  for (const Wrong& wrong : wrong_protocols()) {
    std::string found;
    std::size_t states = 0;
    for (std::uint64_t seed = 1; seed <= kOrders && found.empty(); ++seed) {
      Checker checker(wrong.scenario, kStates, 16, seed * 0x9e3779b97f4a7c15U);
      found = checker.run();
      states += checker.states();
    }
    EXPECT_NE(found, "") << wrong.name;
    printf("%-20s %6zu states: %s\n", wrong.name, states,
           found.substr(0, found.find('\n')).c_str());
  }
}

}  // namespace
}  // namespace mlcca::core::cluster::test
