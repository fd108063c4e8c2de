// SPDX-License-Identifier: BSD-2-Clause
// Buses, gates and traffic for the tests that attach the real gate in a namespace of their own.
#pragma once
#include <bpf/bpf.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <filesystem>
#include <numeric>
#include <thread>

#include "daemon/gates/gate.hpp"
#include "daemon/gates/grace_period.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/tcx.hpp"
#include "tests/daemon/gates/sandbox.hpp"

namespace mlcca::gates {

using test::Bus;
using test::Bytes;
using test::forward;
using test::frame;
using test::Program;

inline constexpr std::uint32_t kMask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;

inline SlotSpec slot(Direction direction, std::uint32_t id) {
  SlotSpec s;
  s.direction = direction;
  s.pass = true;
  s.id = id;
  s.mask = kMask;
  s.subject = id;
  return s;
}
inline SlotSpec in(std::uint32_t id) { return slot(Direction::ingress, id); }
inline SlotSpec out(std::uint32_t id, std::uint32_t source) {
  auto s = slot(Direction::egress, id);
  s.source = source;
  return s;
}
inline SlotSpec user(SlotSpec s, std::uint32_t uid) {
  s.uid = uid;
  return s;
}

inline std::uint64_t seen(const Gate& gate) {
  const auto reasons = gate.reasons(Direction::ingress);
  return std::accumulate(reasons.begin(), reasons.end(), std::uint64_t{0});
}

/// Frames from the bus as fast as they go, from another thread, which has begun.
class Traffic {
 public:
  Traffic(const Bus& bus, const Gate& gate, std::vector<std::uint32_t> ids)
      : thread_([this, &bus, &gate, ids = std::move(ids)] {
          const auto before = seen(gate);
          while (!done_) {
            for (const auto id : ids) bus.inject(frame(id));
            ++rounds_;
            rounds_.notify_one();
            // The kernel's queue is finite: a frame lost there was not lost by the gate.
            while (before + rounds_ * ids.size() > seen(gate) + 200) std::this_thread::yield();
          }
        }) {
    rounds_.wait(0);
  }
  Traffic(const Traffic&) = delete;
  Traffic& operator=(const Traffic&) = delete;
  ~Traffic() { stop(); }

  /// How often each identifier was sent.
  std::uint64_t stop() {
    done_ = true;
    if (thread_.joinable()) thread_.join();
    return rounds_;
  }

 private:
  std::atomic<bool> done_ = false;
  std::atomic<std::uint64_t> rounds_ = 0;
  std::thread thread_;
};

class AttachTo : public ::testing::Test {
 protected:
  explicit AttachTo(Hook hook) : hook_(hook), root_(test::new_bpf_root()), control_(create(root_)) {
    // As long as a test takes on a busy machine.
    EXPECT_TRUE(control_.set_grace(kForEver));
    EXPECT_TRUE(control_.beat(0));
    control_.open();
  }

  static Control create(const std::string& root) {
    auto control = Control::create(root);
    EXPECT_TRUE(control) << control.error().text;
    return std::move(*control);
  }
  Gate attach(const Bus& bus, core::Profile profile = core::Profile::raw) {
    GateConfig config;
    config.ifindex = bus.ifindex();
    config.name = bus.name();
    config.profile = profile;
    config.hook = hook_;
    auto gate = Gate::attach(config, control_);
    EXPECT_TRUE(gate) << gate.error().text;
    return std::move(*gate);
  }
  static void admit(Gate& gate, const std::vector<SlotSpec>& specs) {
    SlotChanges changes;
    changes.add = specs;
    const auto applied = gate.apply(changes);
    ASSERT_TRUE(applied) << applied.error().text;
  }
  /// The number once it is what it should be; else, after a generous time, what it is.
  static std::uint64_t eventually(std::uint64_t wanted, auto number) {
    for (int i = 0; i < 10'000 && number() != wanted; ++i) poll(nullptr, 0, 1);
    return number();
  }
  static void expect_passed(const Gate& gate, const SlotSpec& spec, std::uint64_t frames) {
    EXPECT_EQ(eventually(frames, [&] { return gate.counters(spec).value().passed; }), frames);
  }
  static void expect_dropped(const Gate& gate, const SlotSpec& spec, std::uint64_t frames) {
    EXPECT_EQ(eventually(frames, [&] { return gate.counters(spec).value().dropped; }), frames);
  }
  static void expect_ingress(const Gate& gate, gate_reason reason, std::uint64_t frames) {
    const auto number = [&] { return gate.reasons(Direction::ingress).at(reason); };
    EXPECT_EQ(eventually(frames, number), frames) << core::to_text(gates::reason_of(reason));
  }
  static void expect_egress(const Gate& gate, gate_reason reason, std::uint64_t frames) {
    const auto number = [&] { return gate.reasons(Direction::egress).at(reason); };
    EXPECT_EQ(eventually(frames, number), frames) << core::to_text(gates::reason_of(reason));
  }
  [[nodiscard]] std::string pins(const Bus& bus) const {
    return control_.directory() + "/if" + std::to_string(bus.ifindex());
  }

  Hook hook_;
  std::string root_;
  Control control_;
};

/// What has to hold in either hook.
class Attach : public AttachTo, public ::testing::WithParamInterface<Hook> {
 protected:
  Attach() : AttachTo(GetParam()) {}
};
class Clsact : public AttachTo {
 protected:
  Clsact() : AttachTo(Hook::clsact) {}
};
/// Only where the kernel has it.
class Tcx : public AttachTo, public ::testing::WithParamInterface<Hook> {
 protected:
  Tcx() : AttachTo(Hook::tcx) {}
};
inline std::vector<Hook> all_hooks() {
  return kernel_has_tcx() ? std::vector{Hook::clsact, Hook::tcx} : std::vector{Hook::clsact};
}
inline std::vector<Hook> tcx_if_there() {
  return kernel_has_tcx() ? std::vector{Hook::tcx} : std::vector<Hook>{};
}
inline std::string name_of(const ::testing::TestParamInfo<Hook>& hook) {
  return to_text(hook.param);
}

}  // namespace mlcca::gates
