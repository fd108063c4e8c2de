// SPDX-License-Identifier: BSD-2-Clause
// Silence noticed by the kernel's own timers, on a real clock: the time of each report is compared
// with what the time stamps of the frames say.
#include <deque>
#include <set>

#include "base/clock.hpp"
#include "daemon/gates/events.hpp"
#include "daemon/gates/programs.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint64_t kMillisecond = 1'000'000;
constexpr std::uint64_t kSecond = 1000 * kMillisecond;
constexpr std::uint64_t kPeriod = 100 * kMillisecond;
constexpr std::uint64_t kSilence = 250 * kMillisecond;
constexpr int kPatience = 20'000;  // ms

SlotSpec heart_beat(std::uint32_t id, std::uint64_t silence = kSilence) {
  SlotSpec s = in(id);
  s.period = kPeriod;
  s.silence = silence;
  return s;
}

class WatchAttached : public Clsact {
 protected:
  WatchAttached() : reader_(open_reader()) {}

  EventReader open_reader() {
    auto reader = EventReader::open(control_.events_fd(),
                                    {[this](const gate_event& e) { got_.push_back(e); },
                                     [this](const gate_sample& s) { samples_.push_back(s); }});
    EXPECT_TRUE(reader) << reader.error().text;
    return std::move(*reader);
  }
  /// The next one, waited for.
  gate_event next() {
    for (;;) {
      if (!got_.empty()) {
        const gate_event event = got_.front();
        got_.pop_front();
        return event;
      }
      pollfd ready{reader_.fd(), POLLIN, 0};
      if (HasFailure() || poll(&ready, 1, kPatience) <= 0) {
        ADD_FAILURE() << "nothing was reported";
        return {};
      }
      EXPECT_TRUE(reader_.read());
    }
  }
  /// A heart-beat every fifth of a period, until it is time.
  static void beat_until(const Bus& bus, std::uint32_t id, std::uint64_t end) {
    while (monotonic_ns() < end) {
      bus.inject(frame(id));
      poll(nullptr, 0, 20);
    }
  }
  /// Reported no earlier than it was due, and within a period from then.
  static void expect_missing(const gate_event& event, std::uint64_t since) {
    EXPECT_EQ(event.kind, std::uint32_t{GATE_E_MISSING});
    EXPECT_EQ(event.at - event.silent, since);
    EXPECT_GE(event.silent, kSilence);
    EXPECT_LT(event.silent, kSilence + kPeriod);
  }

  std::deque<gate_event> got_;
  std::deque<gate_sample> samples_;
  EventReader reader_;
};

TEST_F(WatchAttached, AHeartBeatThatNeverComesIsReported) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  const std::uint64_t before = monotonic_ns();
  admit(gate, {heart_beat(1)});
  const std::uint64_t after = monotonic_ns();
  const gate_event event = next();
  EXPECT_EQ(event.kind, std::uint32_t{GATE_E_MISSING});
  EXPECT_EQ(event.ifindex, bus.ifindex());
  EXPECT_EQ(event.subject, 1U);
  EXPECT_EQ(event.slot, gate.number_of(heart_beat(1)));
  EXPECT_EQ(event.never, 1U);
  EXPECT_GE(event.at, before + kSilence);
  EXPECT_LT(event.at, after + kSilence + kPeriod) << "within a period";
  EXPECT_TRUE(gate.arrivals(static_cast<std::uint16_t>(event.slot), monotonic_ns()).silent);
}

/// Health names a publisher that never sent by it.
TEST_F(WatchAttached, WithoutATimeoutTheTimeSinceTheGrantIsKnownToo) {
  const Bus bus("can0");
  std::optional<Gate> gate = attach(bus);
  const std::uint64_t before = monotonic_ns();
  admit(*gate, {heart_beat(1, 0)});
  const std::uint64_t after = monotonic_ns();
  const auto since_last = [&](std::uint64_t now) {
    return gate->arrivals(gate->number_of(heart_beat(1, 0)).value(), now).since_last;
  };
  EXPECT_GE(since_last(after + kPeriod), kPeriod);
  EXPECT_LE(since_last(after + kPeriod), after + kPeriod - before);
  // The next daemon goes on, and only what is opened again restarts.
  gate.reset();
  gate = attach(bus);
  ASSERT_TRUE(gate->reused());
  EXPECT_GE(since_last(after + kPeriod), kPeriod);
  SlotChanges changes;
  changes.close = {heart_beat(1, 0)};
  ASSERT_TRUE(gate->apply(changes));
  changes = {};
  changes.open = {heart_beat(1, 0)};
  const std::uint64_t opened = monotonic_ns();
  ASSERT_TRUE(gate->apply(changes));
  EXPECT_LE(since_last(opened + kPeriod), kPeriod);
  EXPECT_GT(since_last(opened + 2 * kSecond), kSecond);
}

TEST_F(WatchAttached, SilenceAfterTheLastEventIsReportedOnceAndSoIsItsEnd) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  admit(gate, {heart_beat(1)});
  const auto slot = gate.number_of(heart_beat(1)).value();
  beat_until(bus, 1, monotonic_ns() + 6 * kPeriod);
  EXPECT_TRUE(got_.empty());
  const gate_event missing = next();
  const std::uint64_t last = missing.at - gate.arrivals(slot, missing.at).since_last;
  expect_missing(missing, last);
  EXPECT_EQ(missing.never, 0U);
  EXPECT_EQ(gate.arrivals(slot, last + 2 * kPeriod).missing, 2U);

  // It goes on for long: the next report is of its end.
  poll(nullptr, 0, 400);
  const std::uint64_t again = monotonic_ns();
  beat_until(bus, 1, again + GATE_RECOVERY_HOLD + 5 * kPeriod);
  const gate_event restored = next();
  EXPECT_EQ(restored.kind, std::uint32_t{GATE_E_RESTORED});
  EXPECT_GE(restored.at, again + GATE_RECOVERY_HOLD);
  EXPECT_GE(restored.silent, again - last) << "from the last one to the next one, ";
  EXPECT_LT(restored.silent, again - last + 3 * kPeriod) << "as the timer saw it";
  EXPECT_FALSE(gate.arrivals(slot, monotonic_ns()).silent);
  // Then it may be missing again.
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
}

TEST_F(WatchAttached, AnEventStreamThatComesAndGoesIsReportedOnce) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  admit(gate, {heart_beat(1)});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  for (int i = 0; i < 3; ++i) {
    bus.inject(frame(1));
    poll(nullptr, 0, 500);
  }
  admit(gate, {heart_beat(2)});
  const gate_event event = next();
  EXPECT_EQ(event.subject, 2U) << "nothing more was reported of the first";
}

TEST_F(WatchAttached, SilenceOfASlotThatDoesNotPassIsNotReported) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  admit(gate, {heart_beat(1), heart_beat(2), heart_beat(3), heart_beat(4, 0)});
  SlotChanges changes;
  changes.close = {heart_beat(1)};
  changes.remove = {heart_beat(2)};
  changes.police = {heart_beat(3, 0)};
  ASSERT_TRUE(gate.apply(changes));
  admit(gate, {heart_beat(5)});
  EXPECT_EQ(next().subject, 5U);
  // Opened again, the silence timer restarts.
  changes = {};
  changes.open = {heart_beat(1)};
  const std::uint64_t before = monotonic_ns();
  ASSERT_TRUE(gate.apply(changes));
  const gate_event event = next();
  EXPECT_EQ(event.subject, 1U);
  EXPECT_GE(event.at, before + kSilence);
}

TEST_F(WatchAttached, SilenceOfClosedGatesIsNotReported) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  control_.close_all();
  admit(gate, {heart_beat(1)});
  poll(nullptr, 0, 600);
  const std::uint64_t opened = monotonic_ns();
  control_.open();
  const gate_event event = next();
  EXPECT_GE(event.at, opened + kSilence);
}

TEST_F(WatchAttached, TheNextDaemonReadsWhatWasReportedAndWhatIsStillMissing) {
  const Bus bus("can0");
  std::optional<Gate> gate = attach(bus);
  admit(*gate, {heart_beat(1)});
  pollfd ready{reader_.fd(), POLLIN, 0};
  ASSERT_EQ(poll(&ready, 1, kPatience), 1) << "reported, and not read";
  gate.reset();
  control_ = create(root_);
  reader_ = open_reader();
  gate = attach(bus);
  ASSERT_TRUE(gate->reused());
  const gate_event before = next();
  EXPECT_EQ(before.kind, std::uint32_t{GATE_E_MISSING});
  const gate_event once_more = next();
  EXPECT_EQ(once_more.kind, std::uint32_t{GATE_E_MISSING});
  EXPECT_GT(once_more.silent, before.silent) << "the same silence";
  EXPECT_EQ(once_more.at - once_more.silent, before.at - before.silent);
}

TEST_F(WatchAttached, AFloodOfUnknownFramesHidesNothing) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  admit(gate, {heart_beat(1)});
  const auto slot = gate.number_of(heart_beat(1)).value();
  beat_until(bus, 1, monotonic_ns() + 2 * kPeriod);
  const std::uint64_t began = monotonic_ns();
  Traffic flood(bus, gate, {2, 3, 4, 5, 6, 7, 8, 9});
  const gate_event event = next();
  expect_missing(event, event.at - gate.arrivals(slot, event.at).since_last);
  EXPECT_GT(flood.stop(), 0U);
  EXPECT_TRUE(got_.empty());
  const std::uint64_t seconds = (monotonic_ns() - began) / GATE_SAMPLE_NS;
  EXPECT_LE(samples_.size(), GATE_SAMPLES + seconds + 1) << "counted, not reported one by one";
}

TEST_F(WatchAttached, AnUnknownFrameIsReportedAtOnceAndOnceByEachCpu) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  for (int i = 0; i < 300; ++i) bus.inject(frame(0x123));
  bus.inject(frame(CAN_EFF_FLAG | 0x1abcdef));
  while (samples_.empty() || samples_.back().can_id == 0x123) {
    pollfd ready{reader_.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&ready, 1, kPatience), 1);
    ASSERT_TRUE(reader_.read());
  }
  EXPECT_LE(samples_.size(), 1 + possible_cpus());
  const gate_sample first = samples_.front();
  EXPECT_EQ(first.can_id, 0x123U);
  EXPECT_EQ(first.frames, 1U);
  EXPECT_EQ(first.ifindex, bus.ifindex());
  EXPECT_EQ(first.len, 8U);
  EXPECT_EQ(first.direction, GATE_INGRESS);
  EXPECT_EQ(samples_.back().can_id, CAN_EFF_FLAG | 0x1abcdef);
  EXPECT_EQ(samples_.back().frames, 301U) << "with those that were not reported";
}

/// Frames that the gate has seen in this direction.
std::uint64_t unknown_frames(const Gate& gate) {
  return gate.reasons(Direction::ingress)[GATE_R_UNKNOWN];
}

TEST_F(WatchAttached, SamplesOfAFloodAreFewAndItsCountIsExact) {
  constexpr std::uint32_t frames = 100'000;
  const Bus bus("can0");
  Gate gate = attach(bus);
  const std::uint64_t before = monotonic_ns();
  for (std::uint32_t id = 0; id < frames; ++id) bus.inject(frame(CAN_EFF_FLAG | id));
  EXPECT_EQ(unknown_frames(gate), frames);
  const std::uint64_t seconds = (monotonic_ns() - before) / GATE_SAMPLE_NS;
  ASSERT_TRUE(reader_.read());
  EXPECT_GE(samples_.size(), GATE_SAMPLES);
  EXPECT_LE(samples_.size(), GATE_SAMPLES + seconds + 1);
}

TEST_F(WatchAttached, SamplesLeaveHalfOfTheRingToWhatIsMissing) {
  constexpr std::size_t record = sizeof(gate_sample) + 8;  // and the header of a record
  const Bus bus("can0");
  Gate gate = attach(bus);
  const Fd pinned(bpf_obj_get((pins(bus) + "/table").c_str()));
  const Mapped<gate_table> table(pinned.get(), 1);
  std::uint32_t id = 0;
  // Nothing is read for very long: the allowance is given back, as time would.
  for (std::size_t reported = 0; reported < 2 * GATE_EVENTS_SIZE / record;
       reported += GATE_SAMPLES) {
    table[0].sample_due = 0;
    for (int i = 0; i < 64; ++i) bus.inject(frame(CAN_EFF_FLAG | ++id));
  }
  admit(gate, {heart_beat(1)});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  EXPECT_LE(samples_.size(), GATE_EVENTS_SIZE / 2 / record + 1);
  EXPECT_GE(samples_.size(), GATE_EVENTS_SIZE / 2 / record - 1);
}

TEST_F(WatchAttached, TimersThatWereUnpinnedGoOnAndArePinnedAgain) {
  const Bus bus("can0");
  Gate gate = attach(bus);
  ASSERT_TRUE(std::filesystem::remove(pins(bus) + "/silence_timers"));
  admit(gate, {heart_beat(1)});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  EXPECT_EQ(gate.keep_pinned().value(), std::vector<std::string>{"silence_timers"});
  EXPECT_TRUE(gate.keep_pinned().value().empty());
  EXPECT_TRUE(std::filesystem::exists(pins(bus) + "/silence_timers"));
}

TEST_F(WatchAttached, AnEventReachesWhoeverIsWatchedOnAllOfManySlots) {
  constexpr std::uint32_t slots = 500;
  const Bus bus("can0");
  Gate gate = attach(bus);
  std::vector<SlotSpec> specs;
  for (std::uint32_t id = 1; id <= slots; ++id) specs.push_back(heart_beat(id));
  admit(gate, specs);
  std::set<std::uint64_t> reported;
  for (std::uint32_t i = 0; i < slots; ++i) reported.insert(next().subject);
  EXPECT_EQ(reported.size(), slots);
}

}  // namespace
}  // namespace mlcca::gates
