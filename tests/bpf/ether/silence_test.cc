// SPDX-License-Identifier: BSD-2-Clause
// Silence noticed by the kernel's own timers, of real datagrams on a real clock.
#include <deque>

#include "base/clock.hpp"
#include "daemon/gates/events.hpp"
#include "tests/bpf/ether/sockets_fixture.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint64_t kMillisecond = 1'000'000;
constexpr std::uint64_t kPeriod = 100 * kMillisecond;
constexpr std::uint64_t kSilence = 250 * kMillisecond;

class EtherSilence : public EtherSockets {
 protected:
  EtherSilence()
      : reader_(EventReader::open(
                    control_.events_fd(),
                    {[this](const gate_event& e) { got_.push_back(e); }, [](const gate_sample&) {}})
                    .value()) {}
  static SlotSpec watched(std::uint64_t subject = kSubject) {
    SlotSpec s = slot(Direction::ingress, subject);
    s.period = kPeriod;
    s.silence = kSilence;
    return s;
  }
  /// The next one, waited for.
  gate_event next() {
    while (got_.empty() && !HasFailure()) {
      pollfd ready{reader_.fd(), POLLIN, 0};
      EXPECT_EQ(poll(&ready, 1, 20'000), 1) << "nothing was reported";
      EXPECT_TRUE(reader_.read());
    }
    const gate_event event = got_.empty() ? gate_event{} : got_.front();
    if (!got_.empty()) got_.pop_front();
    return event;
  }
  /// A beat each fifth of a period.
  void beat_until(std::uint64_t end) {
    while (monotonic_ns() < end) {
      ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
      poll(nullptr, 0, 20);
    }
  }

  std::deque<gate_event> got_;
  EventReader reader_;
};

TEST_P(EtherSilence, AHeartBeatThatNeverComesIsReportedWithinAPeriod) {
  const std::uint64_t before = monotonic_ns();
  admit({watched()});
  const std::uint64_t after = monotonic_ns();
  const gate_event event = next();
  EXPECT_EQ(event.kind, std::uint32_t{GATE_E_MISSING});
  EXPECT_EQ(event.ifindex, gate_.ifindex());
  EXPECT_EQ(event.subject, kSubject);
  EXPECT_EQ(event.slot, gate_.watched_as(watched()));
  EXPECT_EQ(event.never, 1U);
  EXPECT_GE(event.at, before + kSilence);
  EXPECT_LT(event.at, after + kSilence + kPeriod);
}

TEST_P(EtherSilence, WithoutATimeoutTheTimeSinceTheGrantIsKnownToo) {
  SlotSpec spec = watched();
  spec.silence = 0;
  const std::uint64_t before = monotonic_ns();
  admit({spec});
  const std::uint64_t now = monotonic_ns() + kPeriod;
  const std::uint64_t since = gate_.arrivals(gate_.watched_as(spec).value(), now).since_last;
  EXPECT_GE(since, kPeriod);
  EXPECT_LE(since, now - before);
}

TEST_P(EtherSilence, TheEndOfAHeartBeatAndItsReturnAreReported) {
  admit({watched()});
  const auto number = gate_.watched_as(watched()).value();
  beat_until(monotonic_ns() + 6 * kPeriod);
  EXPECT_TRUE(got_.empty());
  const gate_event missing = next();
  const std::uint64_t last = missing.at - gate_.arrivals(number, missing.at).since_last;
  EXPECT_EQ(missing.at - missing.silent, last);
  EXPECT_GE(missing.silent, kSilence);
  EXPECT_LT(missing.silent, kSilence + kPeriod);
  EXPECT_TRUE(gate_.arrivals(number, monotonic_ns()).silent);
  beat_until(monotonic_ns() + GATE_RECOVERY_HOLD + 5 * kPeriod);
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_RESTORED});
  EXPECT_FALSE(gate_.arrivals(number, monotonic_ns()).silent);
}

TEST_P(EtherSilence, TheNextObjectGoesOnAndReportsOnceMore) {
  admit({watched()});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  gate_ = attach();
  EXPECT_EQ(gate_.present(), std::vector{watched()});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  ASSERT_TRUE(gate_.report_again(gate_.watched_as(watched()).value()));
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  gate_ = attach(20'000);
  EXPECT_EQ(next().subject, kSubject) << "in the larger table, too";
}

TEST_P(EtherSilence, ASlotThatDoesNotPassIsNotSupervised) {
  admit({watched(), watched(kSubject + 1)});
  SlotChanges changes;
  changes.remove = {watched()};
  ASSERT_TRUE(gate_.apply(changes));
  EXPECT_EQ(next().subject, kSubject + 1);
  gate_.deny_all();
  admit({watched(kSubject + 2)});
  EXPECT_EQ(next().subject, kSubject + 2) << "nothing more was reported of the others";
}

INSTANTIATE_TEST_SUITE_P(By, EtherSilence, ::testing::ValuesIn(hooks()), name_of);

}  // namespace
}  // namespace mlcca::gates
