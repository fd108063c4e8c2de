// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/health.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace mlcca {
namespace {

using Lines = std::vector<std::string>;

constexpr std::uint64_t kMillisecond = 1'000'000;
constexpr std::uint64_t kSecond = 1'000'000'000;

control::Watch heart_beat() {
  control::Watch watch;
  watch.period_ns = 50 * kMillisecond;
  watch.timeout_ns = 162 * kMillisecond;
  watch.events = 100;
  watch.since_last_ns = 20 * kMillisecond;
  return watch;
}

Passage in(std::uint64_t passed) {
  Passage p;
  p.network = "second-can";
  p.frames.passed = passed;
  return p;
}

Passage out(std::uint64_t passed) {
  Passage p = in(passed);
  p.network = "robot-can";
  p.leaves = true;
  return p;
}

TEST(Health, NothingIsWrongWithEventsThatComeAndLeave) {
  EXPECT_EQ(troubles({.watch = heart_beat(), .passages = {in(100), out(100)}}), Lines{});
  EXPECT_EQ(troubles({}), Lines{}) << "of a delivery that does not cross this gateway";
}

TEST(Health, ReportsSilenceWithTheMissingEvents) {
  Observed seen{.watch = heart_beat()};
  seen.watch->missing_now = true;
  seen.watch->since_last_ns = 4'200 * kMillisecond + 1;
  EXPECT_EQ(troubles(seen), Lines{"nothing has come for 4.2 s: 84 events are missing"});
  EXPECT_EQ(silent_for(*seen.watch), 4'200 * kMillisecond + 1);
}

/// The field that programs read has the same time as the line for people.
TEST(Health, IsSilentForAsLongAsItsLineSays) {
  control::Watch watch = heart_beat();
  EXPECT_EQ(silent_for(watch), 0U);
  watch.since_last_ns = 15 * kSecond;
  EXPECT_EQ(silent_for(watch), 0U) << "the kernel has not reported it yet";
  watch.timeout_ns = 0;
  EXPECT_EQ(silent_for(watch), 15 * kSecond);
  watch.events = 0;
  EXPECT_EQ(silent_for(watch), 15 * kSecond);
  watch.since_last_ns = kSecond;
  EXPECT_EQ(silent_for(watch), 0U) << "it may be starting";
  watch = heart_beat();
  watch.missing_now = true;
  EXPECT_EQ(silent_for(watch), 0U) << "events come again";
}

TEST(Health, APublisherThatNeverSentIsReportedAfterThreePeriodsAndASecond) {
  Observed seen{.watch = heart_beat()};
  seen.watch->events = 0;
  seen.watch->timeout_ns = 0;
  seen.watch->since_last_ns = kSecond;
  EXPECT_EQ(troubles(seen), Lines{}) << "it may be starting";
  seen.watch->since_last_ns = kSecond + kMillisecond;
  EXPECT_EQ(troubles(seen),
            Lines{"no publisher sends: nothing has come since the gate lets it in, 1.001 s ago"});
  seen.watch->period_ns = 10 * kSecond;
  seen.watch->since_last_ns = 30 * kSecond;
  EXPECT_EQ(troubles(seen), Lines{});
  seen.watch->since_last_ns = 31 * kSecond;
  EXPECT_EQ(troubles(seen),
            Lines{"no publisher sends: nothing has come since the gate lets it in, 31 s ago"});
}

TEST(Health, APublisherThatSendsNoMoreIsReportedWhereNobodyStatesAnOmission) {
  Observed seen{.watch = heart_beat()};
  seen.watch->timeout_ns = 0;
  seen.watch->since_last_ns = kSecond;
  EXPECT_EQ(troubles(seen), Lines{});
  seen.watch->since_last_ns = 15 * kSecond;
  EXPECT_EQ(troubles(seen),
            Lines{"nothing has come for 15 s, and the publisher sends every 50 ms"});
  seen.watch->timeout_ns = 20 * kSecond;
  EXPECT_EQ(troubles(seen), Lines{}) << "its subscriber says that it may";
}

TEST(Health, GatesThatCannotBeListedAreOneShortSentence) {
  EXPECT_EQ(unlisted_gates("list the programs of gates: No such process (libbpf: failed to find "
                           "valid kernel BTF libbpf: Error loading vmlinux BTF: -3 )"),
            "mlccad cannot list the gates of the kernel (its BTF cannot be read): a gate without "
            "pins may be left on an interface that is not described");
  EXPECT_EQ(unlisted_gates("list the interfaces: Cannot allocate memory"),
            "mlccad cannot list the gates of the kernel (the system log says why): a gate without "
            "pins may be left on an interface that is not described");
}

TEST(Health, UnknownFramesAreReportedWhereNothingComes) {
  Observed seen{.watch = control::Watch{}, .passages = {in(0), out(0)}};
  seen.watch->period_ns = 50'000'000;
  seen.watch->since_last_ns = 4 * kSecond;
  seen.unknown = {80, 42};
  seen.latest_unknown = "1F480065";
  EXPECT_EQ(troubles(seen),
            (Lines{"no publisher sends: nothing has come since the gate lets it in, 4 s ago",
                   "80 frames on second-can in the last 42 s named no known subject, the latest "
                   "1F480065: does the publisher send by another name?"}));
  seen.watch->events = 7;
  seen.watch->since_last_ns = 1;
  EXPECT_EQ(troubles(seen), Lines{}) << "its events come";
}

TEST(Health, WhoseSilenceNothingReportsIsNotHealthy) {
  Observed seen{.watch = heart_beat(), .not_supervised = "the gate cannot distinguish a and b"};
  EXPECT_EQ(troubles(seen), Lines{"not supervised: the gate cannot distinguish a and b"});
  seen.watch->missing_now = true;
  seen.watch->since_last_ns = 4'200 * kMillisecond;
  EXPECT_EQ(troubles(seen), (Lines{"nothing has come for 4.2 s: 84 events are missing",
                                   "not supervised: the gate cannot distinguish a and b"}));
}

TEST(Health, DropsAreReportedWithTheirPlace) {
  Observed seen{.passages = {in(100), out(100)}};
  seen.passages[0].excess = {12, 119};
  seen.passages[1].misfits = {1, 0};
  seen.passages[1].frames.last_reason = core::FrameReason::length;
  EXPECT_EQ(troubles(seen),
            (Lines{"12 frames on second-can in the last 119 s were more than was admitted",
                   "1 frame on robot-can in the last 1 s named the subject and differed from the "
                   "grant: longer than granted"}));
  seen.passages[1].would_be_misfits = {2, 121};
  EXPECT_EQ(
      troubles(seen).back(),
      "2 frames on robot-can in the last 3 min named the subject and differed from the grant, the "
      "latest: longer than granted (passed in audit mode)")
      << "and dropped now, perhaps";
  seen.passages[1].frames.last_reason.reset();
  EXPECT_EQ(troubles(seen).back(),
            "2 frames on robot-can in the last 3 min named the subject and differed from the grant "
            "(passed in audit mode)");
  EXPECT_EQ(troubles({.passages = {[] {
                        Passage p = in(100);
                        p.would_exceed = {1, 60};
                        return p;
                      }()}}),
            Lines{"1 frame on second-can in the last 60 s was more than was admitted (passed in "
                  "audit mode)"});
}

TEST(Health, AGrantThatCarriesNothingSaysWhere) {
  EXPECT_EQ(troubles({.passages = {in(40), out(0)}}),
            Lines{"40 frames came in from second-can and none left to robot-can: nothing forwards "
                  "them"});
  EXPECT_EQ(troubles({.passages = {in(1), out(0)}}), Lines{}) << "it may be on its way";
  EXPECT_EQ(troubles({.passages = {in(0), out(0)}}), Lines{}) << "no frame has come";
  EXPECT_EQ(troubles({.passages = {out(0)}}), Lines{}) << "sent by a program here, or not at all";
  auto shared = in(40);
  shared.is_shared = true;
  EXPECT_EQ(troubles({.passages = {shared, out(0)}}), Lines{}) << "perhaps the other one's";
  auto earlier = in(40);
  earlier.passed_before = 40;
  EXPECT_EQ(troubles({.passages = {earlier, out(0)}}), Lines{}) << "left by a slot that is gone";
  auto refused = out(0);
  refused.misfits = {40, 1};
  EXPECT_EQ(troubles({.passages = {in(40), refused}}).back(),
            "40 frames came in from second-can and none left to robot-can");
  EXPECT_EQ(troubles({.passages = {in(40), out(0)}, .not_forwarded = "why"}), Lines{"why"});
}

TEST(Health, AForwarderThatEndsIsSeenAfterItsLastFrame) {
  auto left = out(60);
  left.latest = LatestLeft{.in = 60, .out = 60};
  EXPECT_EQ(troubles({.passages = {in(100), left}}),
            Lines{"40 frames came in from second-can since the latest left to robot-can: nothing "
                  "forwards them"});
  EXPECT_EQ(troubles({.passages = {in(61), left}}), Lines{}) << "it may be on its way";
  auto fragments = in(68);
  fragments.event_frames = 8;
  EXPECT_EQ(troubles({.passages = {fragments, left}}), Lines{}) << "of an event that is not whole";
  left.frames.passed = 61;
  EXPECT_EQ(troubles({.passages = {in(100), left}}), Lines{}) << "they leave";
  left.latest.reset();
  EXPECT_EQ(troubles({.passages = {in(100), left}}), Lines{}) << "it has not been polled";
}

TEST(Health, EventsThatComeAgainAreNotMissing) {
  Observed seen{.watch = heart_beat()};
  seen.watch->missing_now = true;
  seen.watch->since_last_ns = 5 * kMillisecond;
  EXPECT_EQ(troubles(seen), Lines{"events come again, the latest 5 ms ago: not restored yet"});
  seen.watch->timeout_ns = 62 * kMillisecond;
  seen.watch->since_last_ns = 80 * kMillisecond;
  EXPECT_EQ(troubles(seen), Lines{"nothing has come for 80 ms: 1 event is missing"});
}

TEST(Health, IsWhatTheGatesAndTheReasonsMakeIt) {
  EXPECT_EQ(health_of(true, {}).state, control::HealthState::healthy);
  EXPECT_EQ(health_of(true, {"a"}).state, control::HealthState::degraded);
  EXPECT_EQ(health_of(false, {}).state, control::HealthState::closed);
  EXPECT_EQ(health_of(false, {"a"}).state, control::HealthState::closed);
}

TEST(Health, ReportsAsManyReasonsAsFitAndHowManyMoreThereAre) {
  Lines lines;
  for (std::size_t i = 0; i < control::Health::kMostReasons; ++i)
    lines.push_back(fmt::format("{}", i));
  EXPECT_EQ(health_of(true, lines).reasons, lines);
  EXPECT_EQ(health_of(true, lines).left_out, 0U);
  lines.emplace_back("one more");
  EXPECT_EQ(health_of(true, lines).reasons.size(), control::Health::kMostReasons);
  EXPECT_EQ(health_of(true, lines).left_out, 1U);
}

}  // namespace
}  // namespace mlcca
