// SPDX-License-Identifier: BSD-2-Clause
// Real gates in a namespace that somebody tampers with: what is put right, and what is told.
#include "daemon/drift.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>

#include "enforce/attach_fixture.hpp"

namespace mlcca::enforce {
namespace {

class DriftTest : public AttachTo, public testing::WithParamInterface<Hook> {
 protected:
  DriftTest() : AttachTo(GetParam()) {
    gates_.emplace(ifindex(), &gate_);
    EXPECT_TRUE(links_);
  }
  [[nodiscard]] int ifindex() const { return static_cast<int>(bus_.ifindex()); }
  Gate& gate() { return gate_; }
  void repair() { drift_.repair(gates_, links_->table()); }
  void look() { drift_.look_for_bypass(gates_, *links_, control_.mode() == Mode::audit, ++now_); }
  control::Interface report() {
    control::Interface interface;
    drift_.report(ifindex(), gate_, interface);
    return interface;
  }
  void remove_ours() {
    if (hook_ == Hook::clsact)
      test::remove_our_filter(bus_, true);
    else
      std::filesystem::remove(pins(bus_) + "/ingress_link");
  }
  /// Somebody's program that passes everything, before ours at ingress.
  Fd step_in_front() {
    const Fd program = test::load_foreign(0);
    if (hook_ == Hook::tcx)
      return std::move(tcx_attach_first(bus_.ifindex(), Direction::ingress, program.get()).value());
    test::add_foreign_filter(bus_, GATE_TC_PRIORITY, 2, 0);
    return {};
  }

  Bus bus_{"bus0"};
  Gate gate_ = attach(bus_);
  Drift::Gates gates_;
  Result<net::Links> links_ = net::Links::open();
  std::vector<std::string> told_;
  std::vector<Kind> kinds_;
  Drift drift_{[this](Kind kind, const std::string& line, bool) {
    kinds_.push_back(kind);
    told_.push_back(line);
  }};
  std::int64_t now_ = 0;
};

TEST_P(DriftTest, NothingIsToldOfAGateInPlace) {
  repair();
  look();
  EXPECT_TRUE(told_.empty()) << told_.front();
  EXPECT_EQ(report().hook, to_text(hook_));
  EXPECT_EQ(report().repaired, 0U);
}

TEST_P(DriftTest, RemovedGateIsPutBackAndTold) {
  remove_ours();
  repair();
  EXPECT_TRUE(gate().attached().value());
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_EQ(kinds_[0], Kind::drift);
  EXPECT_NE(told_[0].find("somebody removed the gate of bus0"), std::string::npos) << told_[0];
  EXPECT_EQ(report().repaired, 1U);
  repair();
  EXPECT_EQ(told_.size(), 1U) << told_.back();
}

TEST_P(DriftTest, ProgramInFrontIsNamedAndTheGateGoesFirst) {
  const Fd in_front = step_in_front();
  repair();
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_NE(told_[0].find(hook_ == Hook::tcx ? "ran TCX program" : "handle 0x2"), std::string::npos)
      << told_[0];
  EXPECT_NE(told_[0].find("the gate is first again"), std::string::npos) << told_[0];
  EXPECT_EQ(report().drift, "");
  bus_.inject(frame(0x124));
  expect_ingress(gate(), GATE_R_UNKNOWN, 1);
  repair();
  EXPECT_EQ(told_.size(), 1U) << told_.back();
}

TEST_P(DriftTest, FramesPastTheGateAreToldAndCounted) {
  const Program sender(bus_);
  look();
  sender.skip_queueing();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender.send(frame(0x124)));
    ASSERT_TRUE(bus_.sent());
  }
  look();
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_EQ(kinds_[0], Kind::bypass);
  EXPECT_NE(told_[0].find("bus0 has sent 100 frames"), std::string::npos) << told_[0];
  EXPECT_EQ(report().bypassed, 100U);
  look();
  EXPECT_EQ(told_.size(), 1U) << told_.back();
}

TEST_P(DriftTest, FramesThroughTheGateRaiseNoAlarm) {
  const Program sender(bus_);
  admit(gate(), {out(0x123, 0)});
  look();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender.send(frame(0x123)));
    ASSERT_TRUE(bus_.sent());
    EXPECT_FALSE(sender.send(frame(0x124)));
  }
  look();
  EXPECT_TRUE(told_.empty()) << told_.front();
}

TEST_P(DriftTest, FramesThatAuditLetsOutRaiseNoAlarm) {
  const Program sender(bus_);
  control_.set_mode(Mode::audit);
  look();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender.send(frame(0x124)));
    ASSERT_TRUE(bus_.sent());
  }
  look();
  EXPECT_TRUE(told_.empty()) << told_.front();
}

TEST_P(DriftTest, DeviceThatWentToAnotherNamespaceIsTold) {
  repair();
  std::array<int, 2> ready{};
  ASSERT_EQ(pipe(ready.data()), 0);
  const pid_t elsewhere = fork();
  if (elsewhere == 0) {
    if (unshare(CLONE_NEWNET) != 0 || write(ready[1], "", 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  const auto move = "ip link set bus0 netns " + std::to_string(elsewhere);
  ASSERT_EQ(std::system(move.c_str()), 0);
  // The table may have been read before the notice is.
  ASSERT_TRUE(links_->refresh());
  gates_.clear();
  repair();
  kill(elsewhere, SIGKILL);
  waitpid(elsewhere, nullptr, 0);
  const auto moved = links_->take_moved();
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].name, "bus0");
  drift_.tell_moved(moved[0]);
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_EQ(kinds_[0], Kind::drift);
  EXPECT_NE(told_[0].find("bus0 was moved to another network namespace"), std::string::npos);
  drift_.tell_moved({4711, "stranger"});
  EXPECT_EQ(told_.size(), 1U) << "it had no gate";
}

INSTANTIATE_TEST_SUITE_P(Hooks, DriftTest, testing::ValuesIn([] {
                           auto hooks = tcx_if_there();
                           hooks.push_back(Hook::clsact);
                           return hooks;
                         }()),
                         name_of);

}  // namespace
}  // namespace mlcca::enforce
