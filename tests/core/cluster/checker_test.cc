// SPDX-License-Identifier: BSD-2-Clause
// Checks the protocol of a cluster over all interleavings of small cases: real members and views,
// with a store, clocks and messages that do anything they may. CLUSTER_FAULTS=2 lets each fault
// happen once more.
#include "tests/core/cluster/checker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace mlcca::core::cluster::test {
namespace {

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
      {.name = "fenced, dead twice", .steps = 4, .crashes = 2, .fences = 1},
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
      {.name = "replaced",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 4,
       .way = true,
       .wants = {1, 0, 1},
       .releases = 1,
       .replaces = 1,
       .stalls = 1,
       .faulty = {1}},
      {.name = "replaced, refused",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 3,
       .way = true,
       .wants = {1, 0, 1},
       .replaces = 1,
       .refusals = 1},
      {.name = "replaced, late",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 5,
       .way = true,
       .wants = {1, 0, 1},
       .replaces = 1,
       .late = 1,
       .lost = 1},
      {.name = "replaced, dead",
       .gateways = 3,
       .clock_ppm = {kSlow, kSlow, kFast},
       .steps = 8,
       .way = true,
       .wants = {1, 0, 1},
       .replaces = 1,
       .crashes = 1,
       .faulty = {0, 1}},
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
  Scenario ended = way, replaced = way;
  replaced.replaces = 1;
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
      {.name = "GivenBackFirst", .scenario = with(replaced, Mutant::given_back_first)},
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

TEST(ClusterChecker, NothingIsBroken) {
  expect_nothing_broken(scenarios(), {.states = 10'000, .orders = 1, .recover_each = 64});
}

TEST(ClusterChecker, FindsEveryWrongProtocol) { expect_each_found(wrong_protocols(), {}); }

/// Another one for each order.
std::uint64_t seed_of(std::size_t order) { return order * 0x9e3779b97f4a7c15U; }

bool is_left_out(const std::string& name) {
  const char* const only = std::getenv("CLUSTER_SCENARIO");
  return only != nullptr && name != only;
}

}  // namespace

void expect_nothing_broken(const std::vector<Scenario>& scenarios, Effort effort) {
  if (const char* const most = std::getenv("CLUSTER_STATES")) {
    const std::size_t states = std::strtoull(most, nullptr, 10);
    if (effort.orders == 1)
      effort.states = states;
    else
      effort.orders = std::max<std::size_t>(states / effort.states, 1);
  }
  std::size_t sum = 0;
  for (const Scenario& scenario : scenarios) {
    if (is_left_out(scenario.name)) continue;
    std::size_t visited = 0;
    bool all = false;
    for (std::size_t order = 0; order < effort.orders && !all; ++order) {
      Checker checker(scenario, effort.states, effort.recover_each, seed_of(order));
      const std::string found = checker.run();
      if (!found.empty()) ADD_FAILURE() << scenario.name << ": " << found;
      visited += checker.states();
      all = checker.all() && found.empty();
      if (!found.empty()) break;
    }
    printf("%-24s %8zu states%s\n", scenario.name.c_str(), visited, all ? ", all of them" : "");
    fflush(stdout);
    sum += visited;
  }
  printf("%zu states\n", sum);
}

void expect_each_found(const std::vector<Wrong>& all, const Effort& effort) {
  for (const Wrong& wrong : all) {
    if (is_left_out(wrong.name)) continue;
    std::string found;
    std::size_t states = 0;
    for (std::size_t order = 1; order <= effort.orders && found.empty(); ++order) {
      Checker checker(wrong.scenario, effort.states, effort.recover_each, seed_of(order));
      found = checker.run();
      states += checker.states();
    }
    EXPECT_NE(found, "") << wrong.name;
    printf("%-24s %6zu states: %s\n", wrong.name, states,
           found.substr(0, found.find('\n')).c_str());
  }
}

}  // namespace mlcca::core::cluster::test
