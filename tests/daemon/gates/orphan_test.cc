// SPDX-License-Identifier: BSD-2-Clause
// Gates whose daemon and pins are gone: they stay, close by themselves, and a later daemon replaces
// or closes them.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <linux/bpf.h>
#include <sched.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <thread>

#include "daemon/gates/close_unpinned.hpp"
#include "daemon/gates/former_layouts.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/retire.hpp"
#include "daemon/gates/roster.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"
#include "tests/support/becomes.hpp"

namespace mlcca::gates {
namespace {

using test::becomes;

class Orphan : public AttachTo, public ::testing::WithParamInterface<Hook> {
 protected:
  Orphan() : AttachTo(GetParam()) {}

  /// A gate that lets frames of 0x123 in, and out from local programs; then nothing is left of
  /// whoever has put it there: no descriptor, no pin, no timer.
  void leave_behind(const Bus& bus, std::uint64_t grace) {
    {
      auto gate = attach(bus);
      admit(gate, {in(0x123), out(0x123, 0)});
      counters_ = open_pin(cpus_pin(pins(bus)));
    }
    ASSERT_TRUE(counters_);
    ASSERT_TRUE(control_.set_grace(grace));
    std::filesystem::remove_all(root_);
    auto nothing = Control::create_unpinned();
    ASSERT_TRUE(nothing) << nothing.error().text;
    control_ = std::move(*nothing);
  }
  /// Of the gate that was left behind: whoever reads its counters does not keep it in place.
  [[nodiscard]] std::uint64_t counted(gate_reason reason) const {
    const Mapped<gate_cpu> cpus(counters_.get(), possible_cpus());
    return reason_counters(cpus.span(), Direction::ingress).at(reason);
  }
  [[nodiscard]] static std::size_t attached(const Bus& bus) {
    const auto order = tcx_order(bus.ifindex(), Direction::ingress).value();
    const bool filter = test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE) != 0;
    return (order ? order->programs.size() : 0) + (filter ? 1 : 0);
  }

  Fd counters_;
};

TEST_P(Orphan, StaysAndClosesByItself) {
  const Bus bus("bus0");
  leave_behind(bus, 0);
  EXPECT_EQ(attached(bus), 1U);
  EXPECT_TRUE(becomes([&] {
    bus.inject(frame(0x123));
    return counted(GATE_R_CLOSED) > 0;
  }));
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
}

TEST_P(Orphan, IsReplacedByTheNextDaemon) {
  const Bus bus("bus0");
  leave_behind(bus, 0);
  control_ = create(root_ = test::new_bpf_root());
  ASSERT_TRUE(control_.set_grace(kForEver));
  ASSERT_TRUE(control_.beat(0));
  control_.open();
  auto gate = attach(bus);
  EXPECT_FALSE(gate.reused()) << "its slots are not known";
  EXPECT_EQ(attached(bus), 1U);
  admit(gate, {in(0x123)});
  const Program listener(bus);
  bus.inject(frame(0x124));
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123));
}

TEST_P(Orphan, WithAnEndlessGraceIsClosedByADaemonThatCannotCommandIt) {
  const Bus bus("bus0");
  const Bus other("other");
  leave_behind(bus, kForEver);
  EXPECT_TRUE(Program(bus).send(frame(0x123))) << "as it was granted";
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(close_unpinned().value(), std::vector<std::string>{"bus0"});
    EXPECT_FALSE(Program(bus).send(frame(0x123)));
    EXPECT_EQ(attached(bus), 1U) << "however often it is tried";
  }
  EXPECT_TRUE(Program(other).send(frame(0x123))) << "it has no gate";
}

/// A network namespace that goes with this object.
class Elsewhere {
 public:
  Elsewhere() {
    std::array<int, 2> ready{};
    EXPECT_EQ(::pipe(ready.data()), 0);
    const Fd out(ready[1]);
    const Fd in(ready[0]);
    process_ = ::fork();
    if (process_ == 0) {
      if (::unshare(CLONE_NEWNET) != 0 || ::write(out.get(), "", 1) != 1) ::_exit(1);
      ::pause();
      ::_exit(0);
    }
    char byte = 0;
    EXPECT_EQ(::read(in.get(), &byte, 1), 1);
  }
  Elsewhere(const Elsewhere&) = delete;
  Elsewhere& operator=(const Elsewhere&) = delete;
  ~Elsewhere() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  void take(const std::string& device) const {
    const std::string command = fmt::format(
        "ip link set {1} netns {0} && nsenter -t {0} -n ip link set {1} up", process_, device);
    EXPECT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(*-command-processor)
  }
  /// A local program of that namespace sends the frame, and the gate lets it out.
  [[nodiscard]] bool sends(const Bus& bus, std::uint32_t id) const {
    bool sent = false;
    std::thread([&] {
      const Fd there(::open(fmt::format("/proc/{}/ns/net", process_).c_str(),  // NOLINT(*-vararg)
                            O_RDONLY | O_CLOEXEC));
      ASSERT_EQ(::setns(there.get(), CLONE_NEWNET), 0);
      sent = Program(bus).send(frame(id));
    }).join();
    return sent;
  }

 private:
  pid_t process_ = -1;
};

/// A device that has gone to another namespace with a gate, while another one has got its index.
class Moved : public Orphan {
 protected:
  /// No daemon lives; the grace does not end.
  void move() {
    {
      auto gate = attach(bus_);
      admit(gate, {out(0x123, 0)});
      control_.take_over();
    }
    elsewhere_.take(bus_.name());
    ASSERT_TRUE(elsewhere_.sends(bus_, 0x123)) << "as it was granted";
    EXPECT_FALSE(elsewhere_.sends(bus_, 0x124));
    successor_.emplace("bus1", bus_.ifindex());
  }
  void start_a_daemon() {
    control_ = create(root_);
    ASSERT_TRUE(control_.set_grace(kForEver));
    ASSERT_TRUE(control_.beat(0));
  }

  Bus bus_{"bus0"};
  Elsewhere elsewhere_;
  std::optional<Bus> successor_;
};

TEST_P(Moved, IsClosedByTheNextDaemon) {
  move();
  start_a_daemon();
  auto gate = attach(*successor_);
  EXPECT_FALSE(gate.reused());
  admit(gate, {out(0x123, 0)});
  EXPECT_TRUE(Program(*successor_).send(frame(0x123)));
  control_.take_over();
  EXPECT_TRUE(Program(*successor_).send(frame(0x123)));
  EXPECT_FALSE(elsewhere_.sends(bus_, 0x123));
}

TEST_P(Moved, IsClosedByTheNextDaemonAlsoWithoutPins) {
  move();
  std::filesystem::remove_all(pins(bus_));
  start_a_daemon();
  control_.take_over();
  EXPECT_FALSE(elsewhere_.sends(bus_, 0x123));
}

TEST_P(Moved, IsClosedByTheDaemonThatGivesItsPinsToAnother) {
  move();
  const auto gate = attach(*successor_);
  EXPECT_FALSE(gate.reused());
  EXPECT_FALSE(elsewhere_.sends(bus_, 0x123));
}

TEST_P(Orphan, AGateThatIsTakenOverStaysOpenAllTheTime) {
  const Bus bus("bus0");
  for (int daemon = 0; daemon < 3; ++daemon) {
    auto gate = attach(bus);
    if (daemon == 0) admit(gate, {out(0x123, 0)});
    EXPECT_TRUE(Program(bus).send(frame(0x123)));
    control_.take_over();
    EXPECT_TRUE(Program(bus).send(frame(0x123)));
    EXPECT_TRUE(gate.reattach());
    EXPECT_TRUE(Program(bus).send(frame(0x123)));
    control_ = create(root_);
    EXPECT_TRUE(Program(bus).send(frame(0x123))) << "a daemon starts";
  }
}

// With clsact the move takes the qdisc off, and the gate with it.
INSTANTIATE_TEST_SUITE_P(By, Moved, ::testing::ValuesIn(tcx_if_there()), name_of);
INSTANTIATE_TEST_SUITE_P(By, Orphan, ::testing::ValuesIn(all_hooks()), name_of);

TEST_P(Attach, UnpinnedGateOfAnInterfaceThatIsHereStaysInForce) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  gate.unpin();
  EXPECT_FALSE(std::filesystem::exists(pins(bus)));
  EXPECT_TRUE(gate.attached().value());
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
}

TEST_P(Attach, RetiredGateLetsEverythingPassWhereItsDeviceIsNow) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
  retire_gate(pins(bus));
  EXPECT_TRUE(Program(bus).send(frame(0x123)));
  EXPECT_TRUE(attach(bus).reused());
  EXPECT_FALSE(Program(bus).send(frame(0x123))) << "whoever takes it over judges";
}

TEST_P(Attach, AGateThatComesBackWithItsDeviceIsReplaced) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    gate.unpin();
  }
  auto gate = attach(bus);
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
  if (hook_ == Hook::tcx) {
    EXPECT_EQ(tcx_order(bus.ifindex(), Direction::egress).value().value().programs.size(), 1U);
  }
}

TEST_P(Attach, WordOfAnotherLayoutIsClosedAndItsPinsGo) {
  constexpr std::uint32_t layout = GATE_LAYOUT_VERSION - 1;
  const std::string former = root_ + "/v" + std::to_string(layout);
  std::filesystem::create_directories(former + "/if7");
  LIBBPF_OPTS(bpf_map_create_opts, options, .map_flags = BPF_F_MMAPABLE);
  const Fd map(bpf_map_create(BPF_MAP_TYPE_ARRAY, "control", 4, 64, 1, &options));
  ASSERT_EQ(bpf_obj_pin(map.get(), (former + "/control").c_str()), 0);
  ASSERT_EQ(bpf_obj_pin(map.get(), (former + "/if7/egress_link").c_str()), 0);
  struct Former {
    std::uint32_t layout_version;
    std::uint32_t open;
    std::array<std::uint32_t, 14> rest;
  };
  const Mapped<Former> word(map.get(), 1);
  word[0] = {layout, 1, {}};
  word[0].rest.fill(0xabababab);
  ASSERT_TRUE(close_former_layouts(root_));
  EXPECT_EQ(word[0].open, 0U);
  EXPECT_EQ(word[0].rest.front(), 0xababababU);
  EXPECT_FALSE(std::filesystem::exists(former + "/control"));
  EXPECT_TRUE(std::filesystem::exists(former + "/if7/egress_link")) << "it may hold a gate";
  EXPECT_TRUE(control_.is_open());
  EXPECT_TRUE(std::filesystem::exists(control_.directory() + "/control"));
}

/// Its slots say something else: nothing of them is taken over.
TEST_P(Attach, GateOfTheLayoutBeforeIsReplaced) {
  const Bus bus("bus0");
  const Program listener(bus);
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123), in(0x124)});
  }
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123));
  const std::string former = root_ + "/v" + std::to_string(GATE_LAYOUT_VERSION - 1);
  std::filesystem::rename(control_.directory(), former);
  ASSERT_TRUE(close_former_layouts(root_));
  EXPECT_FALSE(control_.is_open());
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
  control_ = create(root_);
  ASSERT_TRUE(control_.set_grace(kForEver));
  ASSERT_TRUE(control_.beat(0));
  control_.open();
  auto gate = attach(bus);
  EXPECT_FALSE(gate.reused());
  admit(gate, {in(0x124)});
  bus.inject(frame(0x123));
  bus.inject(frame(0x124));
  EXPECT_EQ(listener.received(), frame(0x124));
  EXPECT_FALSE(std::filesystem::exists(former + "/if" + std::to_string(bus.ifindex())));
}

/// As layout 3 held its programs.
Fd link_of_layout_3(const Bus& bus, std::uint32_t attach_type, int program) {
  struct {
    std::uint32_t program, ifindex, attach_type, flags, relative, pad;
    std::uint64_t expected_revision;
  } create{static_cast<std::uint32_t>(program), bus.ifindex(), attach_type, 1U << 3, 0, 0, 0};
  return Fd(static_cast<int>(::syscall(SYS_bpf, BPF_LINK_CREATE, &create, sizeof(create))));
}

TEST_P(Tcx, LinkOfLayout3EndsWhereAGateOfOursTakesItsPlace) {
  const Bus bus("bus0");
  const std::string former = root_ + "/v3/if" + std::to_string(bus.ifindex());
  std::filesystem::create_directories(former);
  const Fd drops = test::load_foreign(2);  // TC_ACT_SHOT
  {
    const Fd link = link_of_layout_3(bus, 47, drops.get());
    ASSERT_TRUE(link);
    ASSERT_EQ(bpf_obj_pin(link.get(), (former + "/egress_link").c_str()), 0);
  }
  auto gate = attach(bus);
  admit(gate, {out(0x123, 0)});
  EXPECT_TRUE(Program(bus).send(frame(0x123)));
  EXPECT_FALSE(std::filesystem::exists(former));
}

TEST_P(Attach, ProgramsOfGatesAreKnownByTheMapsTheyRead) {
  const Bus bus("bus0");
  const Fd foreign = test::load_foreign(0);
  const auto gate = attach(bus);
  const auto found = programs_of_gates();  // of the whole machine: others may come and go
  ASSERT_TRUE(found) << found.error().text;
  for (const std::string name : {"/ingress", "/egress"})
    EXPECT_TRUE(found->contains(program_info(open_pin(pins(bus) + name).get()).id)) << name;
  EXPECT_FALSE(found->contains(program_info(foreign.get()).id));
  EXPECT_TRUE(is_of_a_gate(program_info(open_pin(pins(bus) + "/ingress").get()).id));
}

}  // namespace
}  // namespace mlcca::gates
