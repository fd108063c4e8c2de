// SPDX-License-Identifier: BSD-2-Clause
// A description that needs other gates: they are there before any of the old ones goes, and where
// the kernel has no memory for them nothing changes.
#include <dlfcn.h>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <linux/bpf.h>
#include <sys/syscall.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <functional>
#include <string>

#include "daemon/gates/gate_pins.hpp"
#include "daemon/net/pair.hpp"
#include "daemon/ports/ports.hpp"
#include "tests/daemon/gates/sandbox.hpp"
#include "tests/daemon/ports/two_ports.hpp"

namespace {

std::function<bool(long)> fails;  // a command of bpf(2), with ENOMEM

}  // namespace

// NOLINTBEGIN(*-vararg)
extern "C" long syscall(long number, ...) noexcept {
  static const auto call = reinterpret_cast<long (*)(long, ...)>(::dlsym(RTLD_NEXT, "syscall"));
  std::array<long, 6> a{};
  va_list more;
  va_start(more, number);
  for (long& argument : a) argument = va_arg(more, long);
  va_end(more);
  if (number == SYS_bpf && fails && fails(a[0])) return errno = ENOMEM, -1;
  return call(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
// NOLINTEND(*-vararg)

namespace mlcca {
namespace {

constexpr std::size_t kMany = 3'000;  // channels: more than the smallest gate has room for

class ChangeTest : public ::testing::Test {
 protected:
  ChangeTest() {
    for (const int n : {0, 1}) {
      const auto paired = net::make_pair("veth", {fmt::format("eth{}", n), 4711 + n},
                                         {fmt::format("far{}", n), 4721 + n});
      EXPECT_TRUE(paired) << paired.error().text;
    }
    links_.emplace(net::Links::open().value());
    ports_.emplace(
        *links_, control_, net::udev_facts,
        [this](const std::string&, const std::string& line, bool problem) {
          if (problem) reported_ += line + '\n';
        },
        [this](Kind, const std::string& line, bool) { reported_ += line + '\n'; });
    ports_->describe(test::two_ports(1), 0);
    ports_->follow();
    EXPECT_TRUE(ports_->sync(granted())) << reported_;
    control_.open();
    before_ = state();
    EXPECT_NE(before_.find("1 slots"), std::string::npos) << before_;
  }
  ~ChangeTest() override {
    fails = nullptr;
    // NOLINTNEXTLINE(*-command-processor): in a namespace of its own
    static_cast<void>(std::system("ip link del eth0; ip link del eth1"));
  }

  /// One subject comes in by each port.
  static core::GateState granted() {
    core::GateState rules(2);
    for (std::size_t port = 0; port < 2; ++port) {
      rules[port].entry.port = port;
      rules[port].entry.subject = 0x4e6f626f64790000;
      rules[port].entry.max_length = 8;
      rules[port].pass = true;
    }
    return rules;
  }
  /// What frames meet, and what a daemon that starts would find.
  [[nodiscard]] std::string state() {
    std::string text;
    for (std::size_t port = 0; port < 2; ++port) {
      const gates::PortGate* gate = ports_->gate(port);
      if (gate == nullptr) return text + ports_->problem(port);
      const std::string pins = gates::gate_directory(control_.directory(), gate->ifindex());
      const auto ids = gates::in_place({gate->ifindex(), pins, gate->hook()}).value();
      text += fmt::format("{}: programs {} and {}, {} slots{}", gate->name(), ids.ingress,
                          ids.egress, gate->size(), gate->attached().value() ? "" : ", displaced");
      for (const auto& slot : gate->present()) text += slot.pass ? ", passes" : ", denies";
      const auto names = gates::names_in(pins).value();
      for (const std::string& name : names)
        if (name.ends_with("_next")) text += ", left " + name;
      const auto again = gate->keep_pinned().value();
      for (const std::string& name : again) text += ", pinned " + name;
      text += '\n';
    }
    return text;
  }
  /// As a daemon does on a reload.
  Result<void> change_to(const core::System& next) {
    if (auto ready = ports_->prepare(next, 0); !ready) return ready;
    ports_->describe(next, 0);
    Result<void> done = ports_->follow();
    if (done) {
      done = ports_->sync(granted());
    } else {
      ports_->go_back();
      ports_->describe(test::two_ports(1), 0);
      ports_->follow();
      EXPECT_TRUE(ports_->sync(granted()));
    }
    ports_->end_change();
    return done;
  }

  std::string root_ = test::new_bpf_root();
  gates::Control control_ = gates::Control::create(root_).value();
  std::string reported_;
  std::optional<net::Links> links_;
  std::optional<Ports> ports_;
  std::string before_;
};

TEST_F(ChangeTest, AGateThatIsToBeAnotherHasTheSlotsOfTheOneBefore) {
  for (const auto& next : {test::two_ports(kMany), test::two_ports(kMany, core::Refused::silent),
                           test::two_ports(1)}) {
    const auto done = change_to(next);
    ASSERT_TRUE(done) << done.error().text;
    EXPECT_NE(state(), before_);
    EXPECT_EQ(ports_->gate(0)->size(), 1U);
    EXPECT_EQ(state().find("left"), std::string::npos) << state();
    EXPECT_EQ(state().find("pinned"), std::string::npos) << state();
    EXPECT_EQ(reported_, "");
  }
}

TEST_F(ChangeTest, WithoutMemoryForTheMapsOfLargerGatesNothingChanges) {
  for (int n = 1;; n += 5) {
    fails = [n, made = 0](long command) mutable {
      return command == BPF_MAP_CREATE && ++made >= n;
    };
    const auto done = change_to(test::two_ports(kMany));
    fails = nullptr;
    if (done) break;
    ASSERT_LT(n, 100);
    EXPECT_NE(done.error().text.find("Cannot allocate memory"), std::string::npos)
        << done.error().text;
    ASSERT_EQ(state(), before_) << "map " << n;
    ASSERT_EQ(reported_, "") << "map " << n;
    EXPECT_FALSE(ports_->out_of_hand());
  }
}

TEST_F(ChangeTest, WhateverTheKernelRefusesOnceEveryGateIsAsItWasOrAsItIsToBe) {
  const auto other = test::two_ports(kMany, core::Refused::silent);
  int calls = 0;
  const auto is_counted = [](long command) {
    return command != BPF_OBJ_GET && command != BPF_OBJ_GET_INFO_BY_FD && command != BPF_PROG_QUERY;
  };
  fails = [&](long command) { return is_counted(command) && ++calls < 0; };
  ASSERT_TRUE(change_to(other));
  const int all = calls;
  int refused = 0;
  for (int n = 1; n <= all; n += 1 + all / 16) {
    fails = nullptr;
    ASSERT_TRUE(change_to(test::two_ports(1)));
    before_ = state();
    calls = 0;
    fails = [&](long command) { return is_counted(command) && ++calls == n; };
    const auto done = change_to(other);
    fails = nullptr;
    EXPECT_FALSE(ports_->out_of_hand()) << "call " << n;
    ports_->repair();
    if (done) {
      EXPECT_EQ(ports_->gate(0)->size(), 1U) << "call " << n;
      EXPECT_EQ(state().find("displaced"), std::string::npos) << state();
      continue;
    }
    ++refused;
    EXPECT_EQ(state(), before_) << "call " << n << ": " << done.error().text << "\n" << reported_;
  }
  EXPECT_GT(refused, 1) << "of " << all;
}

TEST_F(ChangeTest, WhatWasDeniedMeanwhileStaysSo) {
  ASSERT_TRUE(ports_->prepare(test::two_ports(kMany), 0));
  auto swapped = test::two_ports(kMany);
  std::swap(swapped.gateways[0].ports[0].identity, swapped.gateways[0].ports[1].identity);
  ports_->describe(swapped, 0);
  ports_->follow();
  ports_->end_change();
  for (const std::size_t port : {0, 1})
    for (const auto& slot : ports_->gate(port)->present()) EXPECT_FALSE(slot.pass) << port;
}

}  // namespace
}  // namespace mlcca
