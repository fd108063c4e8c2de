// SPDX-License-Identifier: BSD-2-Clause
// Exact admission to a CAN bus at a utilisation of 0.7: one message more, checked against all
// deadlines, and its release; beside the naive analysis of the whole bus from the formulas.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "core/can/schedule.hpp"
#include "tests/core/can/naive.hpp"
#include "tests/core/can/sets.hpp"

namespace {

using namespace mlcca::core::can;  // NOLINT(google-build-using-namespace): a bench
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kBitrate = 500'000;
constexpr double kSecond = 1e9;  // ns

Assumptions bus() {
  Assumptions assumptions;
  assumptions.timing.bitrate = kBitrate;
  return assumptions;
}

/// Messages with the deadlines of their periods, shorter periods first, at a load of 0.7.
std::vector<Message> messages(std::size_t count) {
  sets::Random random(count);
  auto set = sets::random_set(random, count, {.load = 100, .jitter = false});
  std::ranges::sort(set, {}, &Message::period);
  double load = 0;
  for (const Message& m : set)
    load += static_cast<double>(m.transmission) / static_cast<double>(m.period);
  for (std::size_t i = 0; i < set.size(); ++i) {
    Message& m = set[i];
    m.priority = static_cast<std::uint32_t>(i);
    m.period = static_cast<Time>(static_cast<double>(m.period) * load / 0.7);
    m.deadline = m.period;
  }
  return set;
}

/// Median ns of one call, of rounds that last long enough to be compared.
template <class Call>
double cost_of(const Call& call) {
  std::vector<double> costs;
  for (unsigned round = 0; round < 9; ++round) {
    const auto begin = Clock::now();
    std::uint64_t calls = 0;
    double passed = 0;
    while (passed < kSecond / 50) {
      call();
      ++calls;
      passed = static_cast<double>((Clock::now() - begin).count());
    }
    costs.push_back(passed / static_cast<double>(calls));
  }
  std::ranges::nth_element(costs, costs.begin() + 4);
  return costs[4];
}

void compare(std::size_t count) {
  const auto set = messages(count);
  Schedule schedule(bus());
  for (const Message& m : set)
    if (schedule.add(m)) {
      std::printf("%zu messages do not fit\n", count);
      return;
    }
  // Each in turn leaves and comes back, so that every priority is admitted as often.
  std::size_t next = 0;
  bool refused = false;
  const double added = cost_of([&] {
    const Message& m = set[next];
    next = (next + 1) % set.size();
    schedule.remove(m.key);
    refused = schedule.add(m).has_value() || refused;
  });
  const double whole = cost_of([&] { (void)analyse(bus(), set); });
  const double naive = cost_of([&] {
    for (std::size_t i = 0; i < set.size(); ++i)
      refused =
          naive::response(set, i, bit_time({.bitrate = kBitrate})) > set[i].deadline || refused;
  });
  std::printf(
      "%4zu messages: release and admission %9.2f us, %9.0f/s; whole bus %9.2f us; naive whole bus "
      "%9.2f us: ratio %.4f%s\n",
      count, added / 1e3, kSecond / added, whole / 1e3, naive / 1e3, added / naive,
      refused ? " (REFUSED)" : "");
}

}  // namespace

int main() {
  for (const std::size_t count : {16, 64, 128, 512}) compare(count);
}
