// SPDX-License-Identifier: BSD-2-Clause
// Explores what can happen in a world.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/hash.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

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
    if (!scenario_.orders.empty()) defer(steps);
    for (const Step& step : steps) {
      World next = world;
      path_.push_back(step);
      next.take(step);
      explore(next);
      path_.pop_back();
      if (!found_.empty()) return;
    }
  }
  /// Faults that may happen at any time happen soon if steps are taken at random, and end soon. So
  /// in each order they begin after a number of steps, and in half of the orders they last as long
  /// as anything else can happen.
  void defer(std::vector<Step>& steps) const {
    using enum Step::Kind;
    const bool begin = path_.size() >= hash_with(seed_, 2) % kLatestFault;
    const bool last = hash_with(seed_, 3) >> 63U != 0;
    std::ranges::stable_partition(steps, [&](const Step& step) {
      const bool ends = step.kind == resume || step.kind == restart || step.kind == unstall ||
                        step.kind == outage_ends;
      return ends ? !last : begin || step.kind < object;
    });
  }
  void report(const std::string& what) {
    found_ = what + ":";
    for (const Step& step : path_) found_ += "\n  " + text_of(step);
  }

  static constexpr std::size_t kLongestPath = 500;
  static constexpr std::size_t kLatestFault = 64;  ///< number of steps before it
  const Scenario& scenario_;
  std::size_t most_, recover_each_;
  std::uint64_t seed_;  ///< of the order in which steps are tried
  std::unordered_set<std::pair<std::uint64_t, std::uint64_t>, HashOfPair> seen_;
  std::vector<Step> path_;
  std::string found_;
};

/// A wrong protocol with the smallest scenario that shows it.
struct Wrong {
  const char* name = nullptr;
  Scenario scenario;
};

/// Many short searches in different orders find a fault sooner than a long search in one order,
/// which varies only the end of one run.
struct Effort {
  std::size_t states = 2'000;  ///< of one search
  std::size_t orders = 100;
  std::size_t recover_each = 16;  ///< in one of so many states all faults end
};

// checker_test.cc
/// CLUSTER_STATES states of each instead, if it is set; only of the scenario that
/// CLUSTER_SCENARIO names, if it is set. Prints what was visited.
void expect_nothing_broken(const std::vector<Scenario>& scenarios, Effort effort);
void expect_each_found(const std::vector<Wrong>& all, const Effort& effort);

}  // namespace mlcca::core::cluster::test
