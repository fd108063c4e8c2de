// SPDX-License-Identifier: BSD-2-Clause
// No simulated bus is ever later than the analysis says: SETS random sets of messages (100,000, or
// 10,000,000 by `make soak`) from SEED on, each with adversarial and with random phases. It prints
// in how many of them a bound is reached.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/can/analysis.hpp"
#include "tests/core/bus_simulation/simulator.hpp"

namespace mlcca::testing::bus {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t kSets = 2'000;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr std::uint64_t kSets = 2'000;
#else
constexpr std::uint64_t kSets = 100'000;
#endif
#else
constexpr std::uint64_t kSets = 100'000;
#endif

constexpr Time kMicrosecond = 1'000;
constexpr Time kMillisecond = 1'000'000;
constexpr std::size_t kMostMessages = 9;

std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

struct Kind {
  const char* name;
  std::uint64_t load = 90;  ///< percent of the bus, at most
  bool jitter = false;
  bool equal = false;  ///< priorities
  bool fragmented = false;
  bool paused = false;  ///< events of several frames, of senders that pause between them
  unsigned fifos = 0;
  unsigned priority_queues = 0;
  bool errors = false;
  bool unadmitted = false;
};
constexpr auto kKinds = std::to_array<Kind>({
    {.name = "plain", .load = 95},
    {.name = "jitter", .load = 90, .jitter = true},
    {.name = "equal priorities", .load = 85, .jitter = true, .equal = true},
    {.name = "fragmented events", .load = 75, .fragmented = true},
    {.name = "fragmented, jitter", .load = 70, .jitter = true, .fragmented = true},
    {.name = "unadmitted", .load = 75, .jitter = true, .unadmitted = true},
    {.name = "fifo", .load = 75, .jitter = true, .fragmented = true, .fifos = 1},
    {.name = "two fifos", .load = 65, .fragmented = true, .fifos = 2},
    {.name = "priority queue",
     .load = 75,
     .jitter = true,
     .fragmented = true,
     .priority_queues = 1},
    {.name = "paused", .load = 60, .jitter = true, .paused = true},
    {.name = "paused, equal", .load = 50, .equal = true, .fragmented = true, .paused = true},
    {.name = "paused, unadmitted",
     .load = 50,
     .jitter = true,
     .paused = true,
     .errors = true,
     .unadmitted = true},
    {.name = "errors", .load = 50, .jitter = true, .errors = true},
    {.name = "everything",
     .load = 45,
     .jitter = true,
     .equal = true,
     .fragmented = true,
     .fifos = 1,
     .priority_queues = 1,
     .errors = true,
     .unadmitted = true},
});

struct Set {
  can::Assumptions assumptions;
  std::vector<can::Message> messages;
};

can::Assumptions random_assumptions(const Kind& kind, Random& random) {
  can::Assumptions a;
  a.timing.bitrate = 500'000;
  a.unknown_senders = kind.unadmitted;
  if (kind.errors)
    a.faults = {.count = static_cast<std::uint32_t>(random.between(1, 2)),
                .interval = random.between(3, 20) * kMillisecond};
  const auto depth = [&] { return static_cast<std::uint32_t>(random.between(1, 4)); };
  for (unsigned q = 0; q < kind.fifos; ++q)
    a.queues.push_back({.queueing = core::Queueing::fifo, .fifo_depth = depth()});
  for (unsigned q = 0; q < kind.priority_queues; ++q)
    a.queues.push_back({.queueing = core::Queueing::priority,
                        .fifo_depth = depth(),
                        .bands = random.one_in(3) ? 2U : can::kPrioBands});
  return a;
}

/// Some messages become those of senders that pause: a period has room for what a sender sends.
void pause(Set& set, Random& random) {
  std::array<Time, 3> together{};
  for (can::Message& m : set.messages) {
    if (m.queue != can::kOwnQueue || random.one_in(2)) continue;
    m.frames = static_cast<std::uint32_t>(random.between(2, 5));
    m.last_frame = m.longest_frame;
    m.transmission = m.frames * m.longest_frame;
    m.back_to_back = false;
    m.pauses = (m.frames - 1) * random.between(1, 4000) * kMicrosecond;
    if (!random.one_in(3)) m.sender = static_cast<std::uint32_t>(random.below(together.size()));
    if (m.sender != can::kNoSender) together.at(m.sender) += m.pauses + 2 * m.transmission;
  }
  for (can::Message& m : set.messages) {
    if (m.pauses == 0) continue;
    const Time needed =
        m.sender == can::kNoSender ? m.pauses + 2 * m.transmission : together.at(m.sender);
    m.period = std::max(m.period, needed * random.between(8, 30) / 10);
    m.deadline = m.period + m.jitter;
  }
}

Set random_set(const Kind& kind, Random& random) {
  Set set{random_assumptions(kind, random), {}};
  const std::size_t count = random.between(2, kMostMessages);
  const std::uint64_t load = random.between(20, kind.load);
  for (std::size_t i = 0; i < count; ++i) {
    can::Message& m = set.messages.emplace_back();
    m.key = i;
    m.priority = static_cast<std::uint32_t>(kind.equal ? random.below(count) : i);
    m.back_to_back = random.one_in(2);
    const can::FrameForm form{.extended = random.one_in(2)};
    m.last_frame =
        can::frame_time(set.assumptions.timing, form, static_cast<unsigned>(random.below(9)));
    m.longest_frame = m.last_frame;
    if (kind.fragmented && random.one_in(3)) {
      m.frames = static_cast<std::uint32_t>(random.between(2, 6));
      m.longest_frame = can::frame_time(set.assumptions.timing, form, 8);
    }
    m.transmission = (m.frames - 1) * m.longest_frame + m.last_frame;
    const Time even = m.transmission * count * 100 / load;
    m.period = even * random.between(5, 20) / 10 + random.below(50) * kMicrosecond;
    // Near where the next event waits before the one before it is sent.
    if (m.frames > 1 && random.one_in(4))
      m.period = (m.transmission + m.frames * 320 * kMicrosecond) * random.between(90, 110) / 100;
    if (kind.jitter && random.one_in(2)) m.jitter = random.below(m.period * 3 / 2);
    m.deadline = m.period + m.jitter;
    if (!set.assumptions.queues.empty() && random.one_in(2))
      m.queue = static_cast<std::uint32_t>(random.below(set.assumptions.queues.size()));
  }
  if (kind.paused) pause(set, random);
  if (!kind.equal)
    for (std::size_t i = count; i-- > 1;)
      std::swap(set.messages[i].priority, set.messages[random.below(i + 1)].priority);
  return set;
}

/// The worst that can be thought of for one message: whatever may go before it comes with it, as
/// late as its jitter allows, just after what blocks it longest has begun.
std::vector<Plan> adversarial(const Set& set, std::size_t victim, Time& instant, Random& random) {
  const Time bit = can::bit_time(set.assumptions.timing);
  const can::Message& v = set.messages[victim];
  const bool queued = v.queue != can::kOwnQueue;
  const bool disturbed = random.one_in(3);
  std::uint32_t lowest = v.priority;
  for (const can::Message& m : set.messages) {
    instant = std::max(instant, m.jitter + 64 * bit);
    if (queued && m.queue == v.queue) lowest = std::max(lowest, m.priority);
  }
  std::size_t blocker = set.messages.size();
  const bool fifo = queued && set.assumptions.queues[v.queue].queueing == core::Queueing::fifo;
  const std::uint32_t behind = fifo ? lowest : v.priority;
  for (std::size_t i = 0; i < set.messages.size(); ++i)
    if (set.messages[i].priority > behind &&
        (blocker == set.messages.size() ||
         set.messages[i].longest_frame > set.messages[blocker].longest_frame))
      blocker = i;
  // A sender of one frame at a time gives way before each: then all that is below shall wait.
  const bool all_below = random.one_in(v.frames > 1 || queued ? 2 : 8);
  std::vector<Plan> plans;
  for (std::size_t i = 0; i < set.messages.size(); ++i) {
    const can::Message& m = set.messages[i];
    const bool goes_before = m.priority <= v.priority || (queued && m.queue == v.queue) || fifo;
    Plan plan{.phases = Phases::together, .first = instant};
    if ((i == blocker && !set.assumptions.unknown_senders) || (!goes_before && all_below))
      plan.first -= bit;
    else if (!goes_before || (fifo && m.priority > lowest))
      plan.phases = Phases::never;
    if (i != victim && disturbed && random.one_in(3)) {
      plan.first += random.below(2 * m.longest_frame);
      plan.first -= std::min<Time>(plan.first - m.jitter, random.below(64 * bit));
      if (random.one_in(4)) plan.phases = Phases::random;
    }
    plans.push_back(plan);
  }
  return plans;
}

struct Tally {
  std::uint64_t sets = 0;
  std::uint64_t bounded = 0;  ///< of which some message is
  std::uint64_t reached = 0;  ///< of these: one of its bounds is, to a bit
  std::uint64_t bounds = 0;   ///< of messages
  std::uint64_t exact = 0;    ///< of these: reached
  std::uint64_t late = 0;     ///< messages that exceed their bounds
  std::uint64_t errors = 0;
};

/// `seed`: plays the set again.
void check(const Kind& kind, std::uint64_t seed, Tally& tally) {
  Random random(seed);
  const Set set = random_set(kind, random);
  const auto bounds = can::analyse(set.assumptions, set.messages);
  const Time bit = can::bit_time(set.assumptions.timing);
  std::uint64_t reached = 0;  ///< a bit for each message
  ++tally.sets;
  tally.bounded += std::ranges::any_of(bounds, &can::Response::bounded) ? 1 : 0;
  // Each message is the victim once; then there is a world without malice.
  for (std::size_t attempt = 0; attempt <= set.messages.size(); ++attempt) {
    const bool malicious = attempt < set.messages.size();
    World world;
    world.victim = malicious ? attempt : random.below(set.messages.size());
    world.one_at_a_time = !random.one_in(4);
    world.unadmitted = kind.unadmitted;
    if (kind.errors)
      world.errors = !malicious         ? Errors::random
                     : random.one_in(2) ? Errors::longest
                                        : Errors::always;
    std::vector<Plan> plans(set.messages.size());
    if (malicious)
      plans = adversarial(set, world.victim, world.idle_after, random);
    else
      world.idle_after = ~Time{0};
    world.unadmitted_from = malicious ? world.idle_after - bit : 0;
    world.most_frames = malicious ? 120 : 60;
    const Observed seen = run(set.assumptions, set.messages, plans, world, random);
    tally.errors += seen.errors;
    for (std::size_t i = 0; i < set.messages.size(); ++i) {
      if (!bounds[i].bounded) continue;
      if (seen.response[i] + bit >= bounds[i].response) reached |= std::uint64_t{1} << i;
      const std::uint32_t q = set.messages[i].queue;
      const bool overflow = q != can::kOwnQueue && seen.most_queued[q] > bounds[i].queued_frames;
      if (seen.response[i] <= bounds[i].response && !overflow) continue;
      if (++tally.late > 3) continue;
      ADD_FAILURE() << "message " << i << " of a set of kind " << kind.name << " took "
                    << seen.response[i] << " ns of " << bounds[i].response
                    << (overflow ? ", its queue held too much" : "") << ": SETS=1 SEED=" << seed;
    }
  }
  tally.reached += reached != 0 ? 1 : 0;
  tally.exact += static_cast<std::uint64_t>(std::popcount(reached));
  tally.bounds +=
      static_cast<std::uint64_t>(std::ranges::count(bounds, true, &can::Response::bounded));
}

TEST(BusSimulation, NoResponseIsAboveItsBound) {
  const std::uint64_t sets = from_environment("SETS", kSets);
  const std::uint64_t first = from_environment("SEED", 1);
  std::array<Tally, kKinds.size()> tallies;
  for (std::uint64_t seed = first; seed < first + sets; ++seed)
    check(kKinds[seed % kKinds.size()], seed, tallies[seed % kKinds.size()]);
  Tally all;
  const auto print = [](const char* name, const Tally& t) {
    const auto share = [](std::uint64_t part, std::uint64_t of) {
      return of == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(of);
    };
    std::printf("%-16s %8llu sets: a bound is reached in %5.1f %%, and %5.1f %% of %llu bounds\n",
                name, static_cast<unsigned long long>(t.sets), share(t.reached, t.bounded),
                share(t.exact, t.bounds), static_cast<unsigned long long>(t.bounds));
  };
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    print(kKinds[k].name, tallies[k]);
    all.sets += tallies[k].sets;
    all.bounded += tallies[k].bounded;
    all.reached += tallies[k].reached;
    all.bounds += tallies[k].bounds;
    all.exact += tallies[k].exact;
    all.late += tallies[k].late;
    all.errors += tallies[k].errors;
  }
  print("all", all);
  EXPECT_EQ(all.late, 0U);
  if (sets < 1'000) return;
  // Else hardly anything was tested.
  EXPECT_GT(all.bounded, sets * 9 / 10);
  EXPECT_GT(tallies[0].exact, tallies[0].bounds * 9 / 10);
  EXPECT_GT(all.errors, sets);
}

}  // namespace
}  // namespace mlcca::testing::bus
