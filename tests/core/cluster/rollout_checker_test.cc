// SPDX-License-Identifier: BSD-2-Clause
// Checks rollouts over all interleavings of small cases, as checker_test.cc does admissions.
#include <gtest/gtest.h>

#include <vector>

#include "tests/core/cluster/checker.hpp"

namespace mlcca::core::cluster::test {
namespace {

const Order kRollOut{.gateway = 0, .description = 2};

std::vector<Scenario> rollouts() {
  return {
      {.name = "rollout", .steps = 6, .wants = {0, 0}, .orders = {kRollOut}},
      {.name = "rollout, admission", .steps = 5, .wants = {1, 1}, .orders = {kRollOut}},
      {.name = "rollout, way",
       .steps = 5,
       .way = true,
       .wants = {1, 0},
       .orders = {{.gateway = 1}}},
      {.name = "rollout, dead",
       .steps = 14,
       .wants = {1, 0},
       .crashes = 1,
       .faulty = {0, 1},
       .orders = {kRollOut}},
      {.name = "rollout, paused",
       .steps = 12,
       .wants = {0, 0},
       .pauses = 1,
       .faulty = {0, 1},
       .orders = {kRollOut}},
      {.name = "rollout, outage", .steps = 9, .wants = {0, 1}, .outages = 1, .orders = {kRollOut}},
      {.name = "rollout, blind",
       .steps = 9,
       .wants = {0, 1},
       .stalls = 1,
       .faulty = {0, 1},
       .orders = {kRollOut}},
      {.name = "rollout, late",
       .steps = 6,
       .wants = {0, 0},
       .late = 1,
       .lost = 1,
       .faulty = {0, 1},
       .orders = {kRollOut}},
      {.name = "rollout, objected",
       .steps = 6,
       .wants = {0, 1},
       .faulty = {0, 1},
       .orders = {kRollOut},
       .objections = 1},
      {.name = "rollout, not loaded",
       .steps = 9,
       .wants = {0, 0},
       .faulty = {0, 1},
       .orders = {kRollOut},
       .cannots = 1},
      {.name = "rollout, given up",
       .steps = 9,
       .wants = {0, 1},
       .orders = {kRollOut},
       .cancels = 1},
      {.name = "rollout, given up, late",
       .steps = 9,
       .wants = {0, 0},
       .late = 1,
       .lost = 1,
       .faulty = {0, 1},
       .orders = {kRollOut},
       .cancels = 2},
      {.name = "rollout, given up, dead",
       .steps = 14,
       .wants = {0, 0},
       .crashes = 1,
       .faulty = {0, 1},
       .orders = {kRollOut},
       .cancels = 1},
      {.name = "rollout of three, given up",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 9,
       .wants = {0, 0, 1},
       .orders = {kRollOut},
       .cancels = 1},
      {.name = "two rollouts",
       .steps = 9,
       .wants = {0, 0},
       .orders = {kRollOut, {.gateway = 1, .description = 3}}},
      {.name = "two of one",
       .steps = 9,
       .wants = {0, 0},
       .orders = {kRollOut, {.gateway = 1, .description = 2}}},
      {.name = "rolled back",
       .steps = 9,
       .wants = {0, 0},
       .orders = {kRollOut, {.gateway = 1, .back = true}}},
      {.name = "rolled back, dead",
       .steps = 16,
       .wants = {0, 0},
       .crashes = 1,
       .faulty = {0, 1},
       .orders = {kRollOut, {.gateway = 0, .off = {"B"}, .back = true}}},
      {.name = "called off",
       .steps = 16,
       .wants = {0, 1},
       .crashes = 1,
       .faulty = {1},
       .orders = {{.gateway = 0, .off = {"B"}}}},
      {.name = "called off, paused",
       .steps = 16,
       .wants = {0, 1},
       .pauses = 1,
       .faulty = {1},
       .orders = {{.gateway = 0, .off = {"B"}}}},
      {.name = "called off meanwhile",
       .steps = 16,
       .wants = {0, 0},
       .crashes = 1,
       .faulty = {1},
       .orders = {kRollOut, {.gateway = 0, .off = {"B"}}}},
      {.name = "removed",
       .steps = 16,
       .wants = {0, 1},
       .stalls = 1,
       .crashes = 1,
       .faulty = {1},
       .orders = {{.gateway = 0, .off = {"B"}}, {.gateway = 0, .back = true}},
       .removes = true},
      {.name = "off for good",
       .steps = 16,
       .wants = {0, 0},
       .crashes = 1,
       .faulty = {0, 1},
       .orders = {kRollOut},
       .off_for_good = true},
      {.name = "rollout, compacted",
       .steps = 9,
       .wants = {0, 1},
       .compactions = 1,
       .faulty = {0, 1},
       .orders = {kRollOut}},
      {.name = "rollout of three",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 6,
       .wants = {0, 0, 1},
       .orders = {kRollOut}},
      {.name = "rollout of three, dead",
       .gateways = 3,
       .clock_ppm = {0, 0, 0},
       .steps = 16,
       .wants = {0, 0, 0},
       .crashes = 1,
       .faulty = {0, 2},
       .orders = {kRollOut, {.gateway = 1, .off = {"C"}}}},
  };
}

/// Each with the smallest scenario that shows it.
std::vector<Wrong> wrong_rollouts() {
  const auto with = [](Scenario scenario, Mutant mutant) {
    scenario.mutant = mutant;
    return scenario;
  };
  const Scenario one{.steps = 6, .wants = {0, 0}, .faulty = {0, 1}, .orders = {kRollOut}};
  const Scenario off{.steps = 14,
                     .wants = {0, 1},
                     .crashes = 1,
                     .faulty = {1},
                     .orders = {{.gateway = 0, .off = {"B"}}}};
  Scenario paused = one, two = one, blind = one, objected = one, gone = off;
  paused.pauses = blind.stalls = objected.objections = 1;
  Scenario hung = off;
  hung.crashes = 0;
  hung.pauses = 1;
  two.orders.push_back({.gateway = 0, .description = 3});
  two.steps = 9;
  gone.off_for_good = true;
  gone.orders = {kRollOut};
  return {
      {.name = "CountedWithoutVote", .scenario = with(objected, Mutant::counted_without_vote)},
      {.name = "FormerVoteCounts", .scenario = with(two, Mutant::former_vote_counts)},
      {.name = "OpenAtOnce", .scenario = with(one, Mutant::open_at_once)},
      {.name = "SaidBeforeClosed", .scenario = with(one, Mutant::said_before_closed)},
      {.name = "OpenedBeforeAll", .scenario = with(paused, Mutant::opened_before_all)},
      {.name = "DescribedStaysOpen", .scenario = with(one, Mutant::described_stays_open)},
      {.name = "OpenUnheard", .scenario = with(hung, Mutant::open_unheard)},
      {.name = "OffIgnored", .scenario = with(gone, Mutant::off_ignored)},
  };
}

TEST(ClusterChecker, FindsEveryWrongRollout) {
  expect_each_found(wrong_rollouts(), {.states = 300, .orders = 2'000, .recover_each = 64});
}

TEST(ClusterChecker, NothingIsBrokenByRollouts) {
  expect_nothing_broken(rollouts(), {.states = 300, .orders = 6, .recover_each = 64});
}

}  // namespace
}  // namespace mlcca::core::cluster::test
