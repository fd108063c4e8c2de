// SPDX-License-Identifier: BSD-2-Clause
// What is in force is read back without the object that put it there, and what is wrong is named.
#include "daemon/gates/readback.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/daemon/gates/all_problems.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_P(Attach, ReadBackIsWhatWasPutThere) {
  const Bus bus("bus0");
  auto refused = in(0x200);
  refused.pass = false;
  auto gate = attach(bus);
  admit(gate, {in(0x123), refused});
  const auto reading = read_back(root_);
  ASSERT_TRUE(reading) << reading.error().text;
  EXPECT_TRUE(reading->open);
  ASSERT_EQ(reading->gates.size(), 1U);
  EXPECT_EQ(all_problems(reading->gates[0]), "");
  EXPECT_EQ(reading->gates[0].interface, "bus0");
  EXPECT_EQ(reading->gates[0].hook, hook_);
  EXPECT_EQ(reading->gates[0].slots, gate.present());
}

TEST_P(Attach, ReadBackSaysThatGatesAreClosed) {
  control_.close_all();
  EXPECT_FALSE(read_back(root_).value().open);
}

TEST_F(Clsact, ReadBackNamesARemovedFilter) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  test::remove_our_filter(bus, false);
  EXPECT_EQ(all_problems(read_back(root_).value().gates.at(0)),
            "no program of ours is attached at egress\n");
}

TEST_F(Clsact, ReadBackNamesAnotherProgramInOurPlace) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  test::remove_our_filter(bus, true);
  test::add_foreign_filter(bus, GATE_TC_PRIORITY, GATE_TC_HANDLE);
  EXPECT_NE(all_problems(read_back(root_).value().gates.at(0)).find("is not the pinned one"),
            std::string::npos);
}

TEST_P(Attach, ReadBackNamesMapsOfAnotherGate) {
  const Bus bus("bus0");
  const Bus other("other");
  const auto gate = attach(bus);
  attach(other);
  std::filesystem::rename(pins(other) + "/table", pins(bus) + "/table");
  EXPECT_NE(all_problems(read_back(root_).value().gates.at(0)).find("does not use the pinned"),
            std::string::npos);
}

TEST_P(Attach, ReadBackNamesPinsOfAVanishedInterface) {
  {
    const Bus bus("bus0");
    attach(bus);
  }
  const auto reading = read_back(root_);
  EXPECT_EQ(reading->gates.at(0).interface, "");
  EXPECT_NE(all_problems(reading->gates[0]).find("the pins are left over"), std::string::npos);
}

TEST_P(Attach, ReadBackNamesTimersThatAreNotPinned) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  std::filesystem::remove(pins(bus) + "/silence_timers");
  EXPECT_EQ(all_problems(read_back(root_).value().gates.at(0)),
            "the timers that notice missing events are not pinned\n");
}

TEST_P(Attach, ReadBackOfADamagedTableIsAProblemAndNoCrash) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  const Fd map(bpf_obj_get((pins(bus) + "/table").c_str()));
  Mapped<gate_table>(map.get(), 1)[0].head[GATE_INGRESS][5] = GATE_SLOTS;
  EXPECT_NE(all_problems(read_back(root_).value().gates.at(0)).find("broken chain"),
            std::string::npos);
}

/// The pinned table of a gate, as anyone with the right to it can write there.
class Pinned {
 public:
  explicit Pinned(const std::string& pins) : map_(bpf_obj_get((pins + "/table").c_str())) {}
  gate_slot& slot_of(std::uint64_t subject) {
    return *std::ranges::find(memory_[0].slots, subject, &gate_slot::subject);
  }

 private:
  Fd map_;
  Mapped<gate_table> memory_{map_.get(), 1};
};

TEST_P(Attach, ReadBackNamesAVerdictThatBeginsWithTheNextChange) {
  const Bus bus("bus0");
  auto refused = in(0x123);
  refused.pass = false;
  auto gate = attach(bus);
  admit(gate, {refused});
  Pinned pinned(pins(bus));
  gate_slot& slot = pinned.slot_of(refused.subject);
  slot.verdict[(read_back(root_).value().generation + 1) & 1] = GATE_PASS;
  const auto reading = read_back(root_).value().gates.at(0);
  EXPECT_EQ(reading.slots, std::vector{refused});
  EXPECT_NE(all_problems(reading).find("is another with the next generation"), std::string::npos)
      << all_problems(reading);
}

TEST_P(Attach, ReadBackGivesSlotsAsTheyAreAndNotAsTheyWereMade) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  Pinned pinned(pins(bus));
  gate_slot& slot = pinned.slot_of(in(0x123).subject);
  slot.id = 0x124;  // its bucket is another
  slot.per_frame = 9;
  auto altered = in(0x124);
  altered.subject = 0x123;
  altered.per_frame = 9;
  const auto reading = read_back(root_).value().gates.at(0);
  EXPECT_TRUE(reading.readable);
  EXPECT_EQ(reading.slots, std::vector{altered});
}

TEST_P(Attach, ReadBackNamesAGateThatWasMadeToLetEverythingPass) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  const Fd map(bpf_obj_get((pins(bus) + "/table").c_str()));
  Mapped<gate_table>(map.get(), 1)[0].retired = 1;
  EXPECT_EQ(all_problems(read_back(root_).value().gates.at(0)),
            "another program has altered it: everything passes, as if its interface had left\n");
}

TEST_P(Attach, ReadBackNamesAGateThatNoDaemonHasTakenOver) {
  const Bus bus("bus0");
  {
    const auto gate = attach(bus);
    control_.take_over();
  }
  EXPECT_EQ(all_problems(read_back(root_).value().gates.at(0)), "");
  control_ = create(root_);
  control_.take_over();
  EXPECT_EQ(all_problems(read_back(root_).value().gates.at(0)),
            "no daemon has taken it over: it is closed\n");
}

TEST_P(Tcx, ReadBackNamesAProgramBeforeOurs) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  const Fd foreign = test::load_foreign(0);
  const auto link = tcx_attach_first(bus.ifindex(), Direction::ingress, foreign.get());
  EXPECT_NE(all_problems(read_back(root_).value().gates.at(0)).find("runs before ours at ingress"),
            std::string::npos);
}

/// An open word with a grace of an hour, as anyone with the right to it can write there.
class ReadBackOfGrace : public ::testing::Test {
 protected:
  ReadBackOfGrace() {
    EXPECT_TRUE(control_.set_grace(3'600'000'000'000));
    const auto now = static_cast<std::uint64_t>(
        std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
    EXPECT_TRUE(control_.beat(now));
    EXPECT_TRUE(control_.arm());
    control_.open();
  }
  [[nodiscard]] std::string problems() const {
    std::string all;
    const auto reading = read_back(root_).value();
    for (const auto& problem : reading.problems) all += problem + "\n";
    return all;
  }
  std::string root_ = test::new_bpf_root();
  Control control_ = Control::create(root_).value();
  Mapped<gate_control> word_{control_.map_fd(), 1};
};

TEST_F(ReadBackOfGrace, NamesAGraceThatWasAltered) {
  EXPECT_EQ(problems(), "");
  word_[0].grace_ticks *= 2;
  EXPECT_NE(
      problems().find("another program has altered after which time the gates close without a "
                      "daemon: it is 3600 s in nanoseconds, "),
      std::string::npos)
      << problems();
  word_[0].grace_ticks /= 2;
  word_[0].grace_ns = kForEver;
  EXPECT_NE(problems().find("it is for ever in nanoseconds"), std::string::npos) << problems();
}

TEST_F(ReadBackOfGrace, NamesADeadlineThatWasAltered) {
  word_[0].deadline *= 2;
  EXPECT_NE(
      problems().find("another program has altered when the gates close without a daemon: in "),
      std::string::npos)
      << problems();
  ASSERT_TRUE(control_.set_grace(kForEver));
  EXPECT_EQ(problems(), "") << "they never do";
}

TEST_F(ReadBackOfGrace, NamesAGraceThatIsNotNoted) {
  std::filesystem::remove(control_.directory() + "/grace");
  EXPECT_NE(problems().find("is not noted"), std::string::npos) << problems();
}

TEST(ReadBack, OfNothingIsAnErrorInWords) {
  const auto reading = read_back(test::new_bpf_root());
  ASSERT_FALSE(reading);
  EXPECT_NE(reading.error().text.find("/v" + std::to_string(GATE_LAYOUT_VERSION) +
                                      "/control: No such file"),
            std::string::npos)
      << reading.error().text;
}

}  // namespace
}  // namespace mlcca::gates
