// SPDX-License-Identifier: BSD-2-Clause
// A gate is let go when the kernel says that its interface has gone, and for nothing else.
#include <dirent.h>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <linux/bpf.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "daemon/gates/attachment.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/tcx.hpp"
#include "daemon/net/pair.hpp"
#include "daemon/ports/ports.hpp"
#include "tests/daemon/gates/sandbox.hpp"

namespace {

std::function<int()> fail_receiving;  // errno; 0: received
int fail_queries = 0;                 // errno of each question for the programs of an interface
bool fail_listing = false;            // of a directory

int failure() { return fail_receiving ? fail_receiving() : 0; }

}  // namespace

// NOLINTBEGIN(*-vararg)
extern "C" long syscall(long number, ...) noexcept {
  static const auto call = reinterpret_cast<long (*)(long, ...)>(::dlsym(RTLD_NEXT, "syscall"));
  std::array<long, 6> a{};
  va_list more;
  va_start(more, number);
  for (long& argument : a) argument = va_arg(more, long);
  va_end(more);
  if (number == SYS_bpf && a[0] == BPF_PROG_QUERY && fail_queries != 0)
    return errno = fail_queries, -1;
  return call(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
extern "C" dirent* readdir(DIR* directory) {
  static const auto call = reinterpret_cast<dirent* (*)(DIR*)>(::dlsym(RTLD_NEXT, "readdir"));
  if (fail_listing) return errno = EIO, nullptr;
  return call(directory);
}
extern "C" ssize_t recvmsg(int fd, msghdr* message, int flags) {
  if (const int error = failure(); error != 0) return errno = error, -1;
  return ::syscall(SYS_recvmsg, fd, message, flags);
}
extern "C" ssize_t recvfrom(int fd, void* octets, size_t size, int flags, sockaddr* from,
                            socklen_t* length) {
  if (const int error = failure(); error != 0) return errno = error, -1;
  return ::syscall(SYS_recvfrom, fd, octets, size, flags, from, length);
}
extern "C" ssize_t recv(int fd, void* octets, size_t size, int flags) {
  return recvfrom(fd, octets, size, flags, nullptr, nullptr);
}
// NOLINTEND(*-vararg)

namespace mlcca {
namespace {

core::System one_ethernet() {
  core::System system;
  system.networks.resize(1);
  system.networks[0].name = "lan";
  system.networks[0].kind = core::NetworkKind::udp_multicast;
  system.networks[0].profile = core::Profile::famouso;
  system.gateways.resize(1);
  system.gateways[0].ports.resize(1);
  system.gateways[0].ports[0].identity.name = "eth7";
  return system;
}

void shell(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(*-command-processor)
}

class VanishTest : public ::testing::Test {
 protected:
  VanishTest() {
    const auto paired = net::make_pair("veth", {"eth7", kNear}, {"far7", kFar});
    EXPECT_TRUE(paired) << paired.error().text;
    links_.emplace(net::Links::open().value());
    ports_.emplace(
        *links_, control_, net::udev_facts,
        [this](const std::string&, const std::string& line, bool) { reported_.push_back(line); },
        [this](Kind, const std::string& line, bool) { reported_.push_back(line); });
    ports_->describe(one_ethernet(), 0);
    ports_->follow();
    EXPECT_NE(ports_->gate(0), nullptr) << ports_->problem(0);
    control_.open();
  }
  ~VanishTest() override {
    fail_receiving = nullptr;
    fail_queries = 0;
    fail_listing = false;
    // NOLINTNEXTLINE(*-command-processor): in a namespace of its own
    static_cast<void>(std::system("ip link del eth7 2>/dev/null"));
  }
  void follow() {
    static_cast<void>(links_->refresh());
    ports_->follow();
  }
  [[nodiscard]] std::string pins() const {
    return gates::gate_directory(control_.directory(), kNear);
  }
  [[nodiscard]] bool is_gated() const {
    const auto there = gates::in_place({kNear, pins(), gates::best_hook()});
    return there && there->is_gate();
  }

  void describe_no_port() {
    core::System nothing = one_ethernet();
    nothing.gateways[0].ports.clear();
    ports_->describe(nothing, 0);
    reported_.clear();
    for (int i = 0; i < 2; ++i) ports_->follow();
    EXPECT_EQ(ports_->undescribed(), std::vector<std::string>{"eth7"});
    ASSERT_EQ(reported_.size(), 1U) << "once";
    EXPECT_EQ(reported_[0], "eth7 is not described, or without a profile: its gate stays closed");
    reported_.clear();
  }
  /// As `tc qdisc del … clsact` and `bpftool net detach` do.
  void take_off(gates::Direction direction) {
    const auto program =
        gates::open_pin(pins() + (direction == gates::Direction::ingress ? "/ingress" : "/egress"));
    const auto done = gates::tcx_detach(kNear, direction, program.get());
    EXPECT_TRUE(done) << done.error().text;
  }

  [[nodiscard]] std::string shown() const { return ports_->report().at(0).drift; }

  static constexpr int kNear = 4711;
  static constexpr int kFar = 4712;
  std::string root_ = test::new_bpf_root();
  gates::Control control_ = gates::Control::create(root_).value();
  std::vector<std::string> reported_;
  std::optional<net::Links> links_;
  std::optional<Ports> ports_;
};

TEST_F(VanishTest, AnInterfaceThatAppearsWhileThereIsNoBpffsIsHeldClosed) {
  shell("mount -t tmpfs tmpfs " + root_);
  shell("ip link del eth7");
  follow();
  shell("ip link add eth7 index 4711 type veth peer name far7");
  follow();
  const auto closed = gates::in_place({kNear, {}, gates::Hook::clsact});
  EXPECT_TRUE(closed && closed->is_gate());
  EXPECT_FALSE(ports_->out_of_hand()) << "other gates need not close";
  EXPECT_FALSE(ports_->problem(0).empty());

  shell("umount " + root_);
  follow();
  EXPECT_NE(ports_->gate(0), nullptr);
  EXPECT_TRUE(is_gated());
}

TEST_F(VanishTest, AReadThatFailsLetsNoGateGo) {
  for (const int error : {ENOBUFS, ENOMEM, EIO})
    for (int n = 1; n <= 8; ++n) {
      fail_receiving = [n, error, received = 0]() mutable { return ++received == n ? error : 0; };
      follow();
      ASSERT_TRUE(is_gated()) << "errno " << error << " at " << n;
      fail_receiving = nullptr;
      follow();
      ASSERT_TRUE(is_gated()) << "after errno " << error << " at " << n;
      ASSERT_NE(ports_->gate(0), nullptr);
    }
}

TEST_F(VanishTest, ReadsThatAllFailLetNoGateGo) {
  for (int n = 1; n <= 4; ++n) {
    fail_receiving = [n, received = 0]() mutable { return ++received >= n ? ENOBUFS : 0; };
    follow();
    EXPECT_TRUE(is_gated()) << n;
    EXPECT_NE(ports_->gate(0), nullptr) << n;
    fail_receiving = nullptr;
    follow();
    EXPECT_TRUE(is_gated()) << n;
  }
}

TEST_F(VanishTest, AGateThatCannotBeInspectedIsCommandedAsBeforeAndReportedOnce) {
  reported_.clear();
  fail_queries = ENOMEM;
  for (int n = 0; n < 3; ++n) {
    EXPECT_TRUE(ports_->repair(kNear));
    ASSERT_NE(ports_->gate(0), nullptr) << "a withdrawal would not reach it any more";
  }
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_EQ(reported_[0],
            "the gate of eth7 cannot be inspected, and is commanded as before: tcx query: Cannot "
            "allocate memory");
  EXPECT_EQ(shown(), reported_[0]);
  fail_queries = 0;
  EXPECT_TRUE(ports_->repair(kNear));
  EXPECT_TRUE(is_gated());
  EXPECT_EQ(shown(), "");
}

TEST_F(VanishTest, AGateWhosePinsAreGoneIsClosedAlsoWhereItIsNotDescribedAnyMore) {
  // A crash, then another program removes all pins.
  ports_.reset();
  control_ = gates::Control::create(root_ = test::new_bpf_root()).value();
  ports_.emplace(
      *links_, control_, net::udev_facts,
      [this](const std::string&, const std::string& line, bool) { reported_.push_back(line); },
      [this](Kind, const std::string& line, bool) { reported_.push_back(line); });
  core::System nothing = one_ethernet();
  nothing.gateways[0].ports.clear();
  ports_->describe(nothing, 0);
  reported_.clear();
  fail_queries = ENOMEM;
  ports_->follow();
  ports_->follow();
  ASSERT_EQ(reported_.size(), 1U) << "the same is reported once";
  EXPECT_NE(reported_[0].find("it is unknown which gates without pins"), std::string::npos)
      << reported_[0];
  EXPECT_TRUE(ports_->needs_recheck()) << "it is tried again";
  fail_queries = 0;
  ports_->follow();
  ASSERT_EQ(reported_.size(), 2U);
  EXPECT_EQ(reported_[1], "eth7 is not described, or without a profile: its gate stays closed");
  EXPECT_TRUE(is_gated()) << "by a gate of this daemon, which has pins";
  EXPECT_FALSE(ports_->needs_recheck());
}

TEST_F(VanishTest, AGateThatIsTakenOffAnInterfaceThatIsNotDescribedIsLetGo) {
  describe_no_port();
  for (const auto direction : gates::kBothDirections) take_off(direction);
  EXPECT_TRUE(ports_->repair(kNear));
  EXPECT_FALSE(is_gated());
  EXPECT_FALSE(std::filesystem::exists(pins()));
  EXPECT_FALSE(ports_->next_gate(0));
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_EQ(reported_[0],
            "the gate of eth7, which is not described, was taken off: nothing is judged there any "
            "more");
  ports_->describe(one_ethernet(), 0);
  ports_->follow();
  EXPECT_TRUE(is_gated()) << "it is described again";
  EXPECT_TRUE(ports_->undescribed().empty());
}

/// Or else what is granted there would be dropped.
TEST_F(VanishTest, APortWithoutAProfileCannotBeUsedWhileAFormerGateIsThere) {
  core::System bare = one_ethernet();
  bare.networks[0].profile = core::Profile::none;
  ports_->describe(bare, 0);
  ports_->follow();
  EXPECT_TRUE(is_gated());
  EXPECT_FALSE(ports_->conditions(1)[0].available);
  EXPECT_EQ(ports_->problem(0),
            "lan has no profile, and eth7 has a gate, which stays closed: state a Profile, or take "
            "the gate off");
  EXPECT_TRUE(ports_->undescribed().empty()) << "that is said of the port";
  EXPECT_TRUE(ports_->report().at(0).attached);
  const core::State state(std::move(bare));
  EXPECT_TRUE(ports_->gates(state, "").gates.at(0).attached);
  for (const auto direction : gates::kBothDirections) take_off(direction);
  EXPECT_FALSE(ports_->repair(kNear)) << "follow() is due";
  follow();
  EXPECT_EQ(ports_->problem(0), "");
  EXPECT_FALSE(ports_->report().at(0).attached);
  EXPECT_TRUE(ports_->conditions(1)[0].available);
}

TEST_F(VanishTest, OneThatIsTakenOffInOneDirectionIsPutBack) {
  describe_no_port();
  take_off(gates::Direction::ingress);
  EXPECT_TRUE(ports_->repair(kNear));
  EXPECT_TRUE(is_gated());
  EXPECT_TRUE(ports_->next_gate(0));
}

TEST_F(VanishTest, WhileItIsUnknownWhetherAGateWasTakenOffItIsHeld) {
  describe_no_port();
  for (const auto direction : gates::kBothDirections) take_off(direction);
  fail_queries = ENOMEM;
  static_cast<void>(ports_->repair(kNear));
  EXPECT_TRUE(ports_->next_gate(0));
  fail_queries = 0;
  static_cast<void>(ports_->repair(kNear));
  EXPECT_FALSE(ports_->next_gate(0));
}

TEST_F(VanishTest, TheGateOfAPortIsPutBack) {
  for (const auto direction : gates::kBothDirections) take_off(direction);
  EXPECT_TRUE(ports_->repair(kNear));
  EXPECT_TRUE(is_gated());
}

TEST_F(VanishTest, WhileItIsUnknownWhetherItsInterfaceWentAGateIsHeld) {
  shell("ip link del eth7");
  static_cast<void>(links_->refresh());
  fail_receiving = [] { return ENOBUFS; };
  ports_->follow();
  EXPECT_TRUE(ports_->next_gate(0));
  EXPECT_TRUE(ports_->needs_recheck());
  fail_receiving = nullptr;
  ports_->follow();
  EXPECT_FALSE(ports_->next_gate(0));
  EXPECT_FALSE(ports_->needs_recheck());
}

TEST_F(VanishTest, WhatAFormerDaemonLeftIsOutOfHandUntilItIsKnown) {
  fail_listing = true;
  ports_->follow();
  EXPECT_TRUE(ports_->out_of_hand());
  fail_listing = false;
  ports_->follow();
  EXPECT_FALSE(ports_->out_of_hand());
}

TEST_F(VanishTest, AnInterfaceThatWentTakesItsGateWithIt) {
  shell("ip link del eth7");
  follow();
  EXPECT_EQ(ports_->gate(0), nullptr);
  EXPECT_FALSE(std::filesystem::exists(pins()));
  EXPECT_FALSE(ports_->needs_recheck());
}

TEST_F(VanishTest, WhetherItWentIsFoundOutLaterWithoutAnAnswer) {
  shell("ip link del eth7");
  fail_receiving = [received = 0]() mutable { return ++received > 3 ? ENOBUFS : 0; };
  follow();
  fail_receiving = nullptr;
  follow();
  EXPECT_EQ(ports_->gate(0), nullptr);
  EXPECT_FALSE(std::filesystem::exists(pins()));
}

TEST_F(VanishTest, AnotherInterfaceWithTheNumberGetsAGateOfItsOwn) {
  gates::SlotSpec slot;
  slot.pass = true;
  slot.subject = 5;
  slot.max_len = 8;
  slot.formats = 1;
  gates::SlotChanges changes;
  changes.add = {slot};
  const auto* before = ports_->gate(0);
  const auto done = const_cast<gates::PortGate*>(before)->apply(changes);  // NOLINT(*-const-cast)
  ASSERT_TRUE(done) << done.error().text;
  ASSERT_EQ(before->size(), 1U);
  shell("ip link del eth7");
  shell("ip link add eth7 index 4711 type veth peer name far7");
  follow();
  ASSERT_NE(ports_->gate(0), nullptr);
  EXPECT_TRUE(is_gated());
  EXPECT_EQ(ports_->gate(0)->size(), 0U) << "what was granted was granted to another interface";
  EXPECT_TRUE(ports_->gate(0)->attached().value_or(false));
}

TEST_F(VanishTest, WhereLostNotificationsLeaveItOpenEachIsAskedFor) {
  shell("ip link del eth7");
  // All notifications of the kernel are lost, and no other interface is missing from the list.
  fail_receiving = [received = 0]() mutable { return ++received == 1 ? ENOBUFS : 0; };
  follow();
  EXPECT_EQ(ports_->gate(0), nullptr);
  EXPECT_FALSE(std::filesystem::exists(pins()));
}

}  // namespace
}  // namespace mlcca
