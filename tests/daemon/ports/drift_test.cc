// SPDX-License-Identifier: BSD-2-Clause
// Real gates in a namespace that another program tampers with: what is put right, and what is
// reported.
#include "daemon/ports/drift.hpp"

#include <gtest/gtest.h>
#include <net/if.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <memory>

#include "bpf/ether.h"
#include "daemon/gates/early.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/readback.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

class DriftTest : public AttachTo, public ::testing::WithParamInterface<Hook> {
 protected:
  DriftTest() : AttachTo(GetParam()) {
    gates_.emplace(ifindex(), &gate_);
    EXPECT_TRUE(links_);
  }
  [[nodiscard]] int ifindex() const { return static_cast<int>(bus_.ifindex()); }
  Gate& gate() { return gate_; }
  void repair() { drift_.repair(gates_, links_->table()); }
  /// It was repaired and reported, and there is nothing more to repair.
  void expect_repaired_once(const std::string& line) {
    ASSERT_EQ(reported_.size(), 1U);
    EXPECT_EQ(kinds_[0], Kind::drift);
    EXPECT_EQ(reported_[0], line);
    EXPECT_EQ(report().repaired, 1U);
    repair();
    EXPECT_EQ(reported_.size(), 1U) << reported_.back();
  }
  void check_bypass() { drift_.check_bypass(gates_, *links_, ++now_); }
  control::Interface report() {
    control::Interface interface;
    drift_.report(ifindex(), gate_, interface);
    return interface;
  }
  void remove_ours() {
    if (hook_ == Hook::clsact)
      test::remove_our_filter(bus_, true);
    else
      EXPECT_TRUE(
          tcx_detach(bus_.ifindex(), Direction::ingress, open_pin(pins(bus_) + "/ingress").get()));
  }
  /// A program of another user that passes everything, before ours at ingress.
  void step_in_front() {
    const Fd program = test::load_foreign(0);
    if (hook_ == Hook::tcx)
      EXPECT_TRUE(tcx_attach_first(bus_.ifindex(), Direction::ingress, program.get()));
    else
      test::add_foreign_filter(bus_, GATE_TC_PRIORITY, 2, 0);
  }

  Bus bus_{"bus0"};
  Gate gate_ = attach(bus_);
  Drift::Gates gates_;
  Result<net::Links> links_ = net::Links::open();
  std::vector<std::string> reported_;
  std::vector<Kind> kinds_;
  Drift drift_{[this](Kind kind, const std::string& line, bool) {
    kinds_.push_back(kind);
    reported_.push_back(line);
  }};
  std::int64_t now_ = 0;
};

TEST_P(DriftTest, NothingIsReportedOfAGateInPlace) {
  repair();
  check_bypass();
  EXPECT_TRUE(reported_.empty()) << reported_.front();
  EXPECT_EQ(report().hook, to_text(hook_));
  EXPECT_EQ(report().repaired, 0U);
}

TEST_P(DriftTest, RemovedGateIsPutBackAndReported) {
  remove_ours();
  repair();
  EXPECT_TRUE(gate().attached().value());
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_EQ(kinds_[0], Kind::drift);
  EXPECT_NE(reported_[0].find("another program removed the gate of bus0"), std::string::npos)
      << reported_[0];
  EXPECT_EQ(report().repaired, 1U);
  repair();
  EXPECT_EQ(reported_.size(), 1U) << reported_.back();
}

TEST_P(DriftTest, AGateOfAnotherDaemonInItsPlaceIsReplacedAndNotReportedAsOpen) {
  const auto elsewhere = Control::create(test::new_bpf_root()).value();
  GateConfig config;
  config.ifindex = bus_.ifindex();
  config.name = bus_.name();
  config.profile = core::Profile::raw;
  config.hook = hook_;
  const auto usurper = Gate::attach(config, elsewhere);
  ASSERT_TRUE(usurper) << usurper.error().text;
  repair();
  EXPECT_TRUE(gate().attached().value());
  EXPECT_FALSE(usurper->attached().value());
  ASSERT_EQ(reported_.size(), 1U) << reported_.front();
  EXPECT_EQ(reported_[0],
            "another daemon had put its gate in the place of that of bus0, which is back: two "
            "daemons with --bpf-root of their own close each other's gates");
  EXPECT_EQ(report().repaired, 1U);
}

TEST_P(DriftTest, UnpinnedGateIsPinnedAgainAndReported) {
  admit(gate(), {in(0x123)});
  bus_.inject(frame(0x123));
  expect_passed(gate(), in(0x123), 1);
  std::filesystem::remove_all(pins(bus_));
  bus_.inject(frame(0x123));
  expect_passed(gate(), in(0x123), 2);
  repair();
  ASSERT_EQ(reported_.size(), 1U) << reported_.back();
  EXPECT_EQ(kinds_[0], Kind::drift);
  for (const char* part :
       {"another program unpinned silence_timers, table, cpus, ", "egress", "ingress",
        " of the gate of bus0: pinned again, and nothing else has changed"})
    EXPECT_NE(reported_[0].find(part), std::string::npos) << reported_[0];
  EXPECT_EQ(report().repaired, 1U);
  EXPECT_TRUE(gate().attached().value());
  const auto reading = read_back(root_).value().gates.at(0);
  EXPECT_TRUE(reading.problems.empty()) << reading.problems.front();
  EXPECT_EQ(reading.slots, std::vector{in(0x123)});
  bus_.inject(frame(0x123));
  expect_passed(gate(), in(0x123), 3);
  repair();
  EXPECT_EQ(reported_.size(), 1U) << reported_.back();
}

TEST_P(DriftTest, AGateThatWasMadeToLetEverythingPassJudgesAgainAndThatIsReported) {
  const Program sender(bus_);
  const Fd map = open_pin(pins(bus_) + "/table");
  Mapped<gate_table>(map.get(), 1)[0].retired = 1;
  EXPECT_TRUE(sender.send(frame(0x124)));
  repair();
  EXPECT_FALSE(sender.send(frame(0x124)));
  expect_repaired_once(
      "another program altered the gate of bus0: it let everything pass until now, and "
      "judges again");
}

TEST_P(DriftTest, AGateThatWasGivenToNoDaemonIsHeldAgainAndThatIsReported) {
  admit(gate(), {in(0x123)});
  const Fd map = open_pin(pins(bus_) + "/table");
  const Mapped<gate_table> table(map.get(), 1);
  const auto held = table[0].epoch;
  table[0].epoch = 0;
  repair();
  EXPECT_EQ(table[0].epoch, held);
  expect_repaired_once(
      "another program altered which daemon holds the gate of bus0: it was closed until now, "
      "and holds what is granted again");
}

TEST_P(DriftTest, DaemonAfterThatTakesTheSameGateOver) {
  admit(gate(), {in(0x123)});
  std::filesystem::remove_all(pins(bus_));
  repair();
  const Gate next = attach(bus_);
  EXPECT_TRUE(next.reused());
  EXPECT_EQ(next.present(), std::vector{in(0x123)});
}

TEST_P(DriftTest, PinOfAnotherGateIsReplacedByOurs) {
  const Bus other("other");
  const Gate foreign = attach(other);
  std::filesystem::rename(pins(other) + "/table", pins(bus_) + "/table");
  repair();
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_NE(reported_[0].find("unpinned table of the gate of bus0"), std::string::npos)
      << reported_[0];
  EXPECT_TRUE(read_back(root_).value().gates.at(0).problems.empty());
}

TEST_P(DriftTest, GateThatCannotBePinnedIsReportedOnceAndInTheStatus) {
  const std::string table = pins(bus_) + "/table";
  std::filesystem::remove(table);
  std::filesystem::create_directories(table + "/of/somebody");
  repair();
  repair();
  ASSERT_EQ(reported_.size(), 1U) << reported_.back();
  EXPECT_NE(
      reported_[0].find("the gate of bus0 is not pinned, and a daemon that starts would begin"),
      std::string::npos)
      << reported_[0];
  EXPECT_NE(reported_[0].find("remove it (rm -r " + table + ")"), std::string::npos)
      << reported_[0];
  EXPECT_EQ(report().drift, reported_[0]);
  std::filesystem::remove_all(table);
  repair();
  EXPECT_EQ(reported_.size(), 2U) << reported_.back();
  EXPECT_EQ(report().drift, "");
}

/// The bpffs of the tests, until it goes.
class ReadOnly {
 public:
  explicit ReadOnly(std::string point) : point_(std::move(point)) { remount(MS_RDONLY); }
  ReadOnly(const ReadOnly&) = delete;
  ReadOnly(ReadOnly&&) = delete;
  ReadOnly& operator=(const ReadOnly&) = delete;
  ReadOnly& operator=(ReadOnly&&) = delete;
  ~ReadOnly() { remount(0); }

 private:
  void remount(unsigned long flags) const {
    EXPECT_EQ(::mount(nullptr, point_.c_str(), nullptr, MS_REMOUNT | flags, nullptr), 0);
  }
  std::string point_;
};

TEST_P(DriftTest, AReadOnlyBpffsIsReportedOnceAndNothingIsSaidToBePutRight) {
  ASSERT_TRUE(control_.arm());
  {
    const ReadOnly bpffs(std::filesystem::path(root_).parent_path());
    repair();
    repair();
    ASSERT_EQ(reported_.size(), 1U) << reported_.back();
    EXPECT_NE(reported_[0].find("the gate of bus0 is not pinned"), std::string::npos)
        << reported_[0];
    EXPECT_NE(reported_[0].find("Read-only file system"), std::string::npos) << reported_[0];
    EXPECT_EQ(report().drift, reported_[0]);
    EXPECT_EQ(report().repaired, 0U);
    const auto control = control_.keep_pinned();
    ASSERT_FALSE(control);
    EXPECT_NE(control.error().text.find("Read-only file system"), std::string::npos);
  }
  repair();
  EXPECT_EQ(reported_.size(), 1U) << reported_.back();
  EXPECT_EQ(report().drift, "");
  EXPECT_EQ(report().repaired, 0U) << "its pins are as they were";
}

TEST_P(DriftTest, ProgramInFrontIsNamedAndTheGateGoesFirst) {
  step_in_front();
  repair();
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_NE(reported_[0].find(hook_ == Hook::tcx ? "ran TCX program" : "handle 0x2"),
            std::string::npos)
      << reported_[0];
  EXPECT_NE(reported_[0].find("the gate is first again"), std::string::npos) << reported_[0];
  EXPECT_EQ(report().drift, "");
  bus_.inject(frame(0x124));
  expect_ingress(gate(), GATE_R_UNKNOWN, 1);
  repair();
  EXPECT_EQ(reported_.size(), 1U) << reported_.back();
}

TEST_P(DriftTest, FramesPastTheGateAreReportedAndCounted) {
  const Program sender(bus_);
  check_bypass();
  sender.skip_queueing();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender.send(frame(0x124)));
    ASSERT_TRUE(bus_.sent());
  }
  check_bypass();
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_EQ(kinds_[0], Kind::bypass);
  EXPECT_NE(reported_[0].find("bus0 has sent 100 frames"), std::string::npos) << reported_[0];
  EXPECT_EQ(report().bypassed, 100U);
  check_bypass();
  EXPECT_EQ(reported_.size(), 1U) << reported_.back();
}

TEST_P(DriftTest, FramesThroughTheGateRaiseNoAlarm) {
  const Program sender(bus_);
  admit(gate(), {out(0x123, 0)});
  check_bypass();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender.send(frame(0x123)));
    ASSERT_TRUE(bus_.sent());
    EXPECT_FALSE(sender.send(frame(0x124)));
  }
  check_bypass();
  EXPECT_TRUE(reported_.empty()) << reported_.front();
}

TEST_P(DriftTest, FramesThatAuditLetsOutRaiseNoAlarm) {
  const Program sender(bus_);
  control_.set_mode(Mode::audit);
  check_bypass();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender.send(frame(0x124)));
    ASSERT_TRUE(bus_.sent());
  }
  check_bypass();
  EXPECT_TRUE(reported_.empty()) << reported_.front();
}

TEST_P(DriftTest, DeviceThatWentToAnotherNamespaceIsReported) {
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
  drift_.report_moved(moved[0]);
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_EQ(kinds_[0], Kind::drift);
  EXPECT_NE(reported_[0].find("bus0 was moved to another network namespace"), std::string::npos);
  drift_.report_moved({4711, "foreign"});
  EXPECT_EQ(reported_.size(), 1U) << "it had no gate";
}

/// Generic XDP runs before tc on any device, CAN too.
TEST_P(DriftTest, AnXdpProgramInFrontIsReportedAndStays) {
  const auto id = test::put_foreign_xdp("bus0");
  repair();
  repair();
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_NE(reported_[0].find("before the gate of bus0 runs XDP program " + std::to_string(id)),
            std::string::npos)
      << reported_[0];
  EXPECT_EQ(report().drift, reported_[0]);
  EXPECT_EQ(other_early_programs(bus_.ifindex(), 0), std::vector{id});
  test::remove_foreign_xdp("bus0");
  repair();
  ASSERT_EQ(reported_.size(), 2U);
  EXPECT_EQ(reported_[1], "no other XDP program runs before the gate of bus0 any more");
  EXPECT_EQ(report().drift, "");
}

/// Of an Ethernet gate.
class DriftInTheDriver : public DriftTest {
 protected:
  DriftInTheDriver() {
    shell("ip link add lan0 type veth peer name far0");
    auto made = EtherGate::attach({if_nametoindex("lan0"), "lan0", 0, hook_}, control_);
    EXPECT_TRUE(made) << made.error().text;
    ether_ = std::make_unique<EtherGate>(std::move(*made));
    gates_ = {{static_cast<int>(ether_->ifindex()), ether_.get()}};
    EXPECT_TRUE(links_->refresh());
  }
  ~DriftInTheDriver() override { shell("ip link del lan0"); }
  static void shell(const std::string& command) {
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
  }
  [[nodiscard]] std::string status() const {
    control::Interface interface;
    drift_.report(static_cast<int>(ether_->ifindex()), *ether_, interface);
    return interface.drift;
  }
  std::unique_ptr<EtherGate> ether_;
};

TEST_P(DriftInTheDriver, WhatIsGoneFromThereAloneIsReportedAsThat) {
  repair();
  EXPECT_TRUE(reported_.empty()) << reported_.front();
  shell("ip link set lan0 xdp off");
  repair();
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_EQ(reported_[0],
            "another program removed ours from the driver of lan0: what is refused was dropped "
            "behind packet sockets until now, and is dropped early again");
  EXPECT_TRUE(ether_->drops_early());
  repair();
  EXPECT_EQ(reported_.size(), 1U) << reported_.back();
}

TEST_P(DriftInTheDriver, AnotherProgramInsteadOfOursIsReportedAndLeft) {
  repair();
  shell("ip link set lan0 xdp off");
  const auto id = test::put_foreign_xdp("lan0");
  repair();
  repair();
  ASSERT_EQ(reported_.size(), 2U);
  EXPECT_NE(reported_[0].find("and still is"), std::string::npos) << reported_[0];
  EXPECT_NE(reported_[1].find("runs XDP program " + std::to_string(id)), std::string::npos)
      << reported_[1];
  EXPECT_EQ(status(), reported_[1]);
  EXPECT_EQ(other_early_programs(ether_->ifindex(), ether_->early()), std::vector{id});
  const auto reading = read_back(root_).value();
  const auto gate = std::ranges::find(reading.gates, "lan0", &GateReading::interface);
  ASSERT_NE(gate, reading.gates.end());
  EXPECT_EQ(gate->problems,
            std::vector{"XDP program " + std::to_string(id) + " runs before ours at ingress"});
  test::remove_foreign_xdp("lan0");
  repair();
  EXPECT_EQ(reported_.size(), 3U) << reported_.back();
  EXPECT_EQ(status(), "");
  EXPECT_TRUE(ether_->drops_early()) << "its place is free again";
  EXPECT_TRUE(read_back(root_).value().gates.at(1).problems.empty());
}

TEST_P(DriftInTheDriver, UnpinnedEthernetGateIsPinnedAgainAndReported) {
  const std::string pins = gate_directory(control_.directory(), ether_->ifindex());
  SlotSpec admitted;
  admitted.pass = true;
  admitted.formats = ETHER_UNFRAGMENTED;
  admitted.subject = 7;
  SlotChanges changes;
  changes.add = {admitted};
  ASSERT_TRUE(ether_->apply(changes));
  std::filesystem::remove_all(pins);
  repair();
  ASSERT_GE(reported_.size(), 1U);
  EXPECT_NE(reported_[0].find("another program unpinned early, silence_timers, ether_table"),
            std::string::npos)
      << reported_[0];
  repair();
  EXPECT_TRUE(read_back(root_).value().gates.at(1).problems.empty())
      << read_back(root_).value().gates.at(1).problems.front();
  EXPECT_EQ(read_back(root_).value().gates.at(1).slots, ether_->present());
  const auto before = reported_.size();
  repair();
  EXPECT_EQ(reported_.size(), before) << reported_.back();
}

TEST_P(DriftInTheDriver, OneOfOursThatIsNotThePinnedOneIsReadBack) {
  std::filesystem::remove(early_pin(gate_directory(control_.directory(), ether_->ifindex())));
  const auto reading = read_back(root_).value();
  const auto gate = std::ranges::find(reading.gates, "lan0", &GateReading::interface);
  ASSERT_NE(gate, reading.gates.end());
  EXPECT_EQ(gate->problems,
            std::vector{"our XDP program in the driver (" + std::to_string(ether_->early()) +
                        ") is not the pinned one (0)"});
}

INSTANTIATE_TEST_SUITE_P(Hooks, DriftTest, ::testing::ValuesIn([] {
                           auto hooks = tcx_if_there();
                           hooks.push_back(Hook::clsact);
                           return hooks;
                         }()),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Hooks, DriftInTheDriver, ::testing::ValuesIn([] {
                           auto hooks = tcx_if_there();
                           hooks.push_back(Hook::clsact);
                           return hooks;
                         }()),
                         name_of);

}  // namespace
}  // namespace mlcca::gates
