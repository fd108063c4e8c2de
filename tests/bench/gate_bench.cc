// SPDX-License-Identifier: BSD-2-Clause
// What the gate costs: ns of a frame above an empty tc program, by BPF_PROG_TEST_RUN in this
// process; and a verdict flip against one map-update system call. Prints JSON; ratios come from the
// same run.
#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <fmt/format.h>
#include <linux/pkt_cls.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "daemon/gates/bindings.hpp"
#include "tests/bench/timing.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr int kRuns = 1000;  // short ones, and the best of them: the others were disturbed
constexpr int kRepeat = 20'000;
constexpr std::uint32_t kRtr = CAN_RTR_FLAG;
constexpr std::uint32_t kEff = CAN_EFF_FLAG;

double nanoseconds_of(const auto& work, int repeat) { return best_of(kRuns, repeat, work); }

double empty_program_ns() {
  const Fd fd = empty_program();
  const Bytes bytes = frame(0x123, 8);
  return nanoseconds_of(
      [&](int repeat) {
        LIBBPF_OPTS(bpf_test_run_opts, run);
        run.data_in = bytes.data();
        run.data_size_in = static_cast<std::uint32_t>(bytes.size());
        run.repeat = repeat;
        if (bpf_prog_test_run_opts(fd.get(), &run) != 0) std::abort();
      },
      kRepeat);
}

SlotSpec slot(Direction direction, std::uint32_t id, bool pass, std::uint32_t source = 0) {
  SlotSpec s;
  s.direction = direction;
  s.pass = pass;
  s.id = id;
  s.mask = kEff | kRtr | ((id & kEff) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK);
  s.source = source;
  return s;
}

struct Case {
  const char* name;
  std::uint32_t profile;
  Direction direction;
  std::uint32_t id;
  bool local;
  bool direct_access = true;
  std::uint16_t bindings = 0;  ///< tags that a broker's reply is held against
};

// A test run gives the same buffer again with the mark of the last run. So a frame that passes is
// measured on egress, where local frames keep mark 0, and one that is dropped on ingress.
constexpr std::array kCases = {
    Case{"raw dense pass", GATE_PROFILE_RAW, Direction::egress, 0x123, true},
    Case{"raw dense drop", GATE_PROFILE_RAW, Direction::ingress, 0x124, false},
    Case{"raw sparse hit", GATE_PROFILE_RAW, Direction::egress, kEff | 0x1abcdef, true},
    Case{"raw sparse miss", GATE_PROFILE_RAW, Direction::ingress, kEff | 0x1abcdee, false},
    Case{"famouso pass", GATE_PROFILE_FAMOUSO, Direction::egress, kEff | 0x64, true},
    Case{"famouso drop", GATE_PROFILE_FAMOUSO, Direction::ingress, kEff | 0x65, false},
    Case{"famouso last of 8 publishers", GATE_PROFILE_FAMOUSO, Direction::egress, kEff | 0x66,
         true},
    Case{"famouso reply, 16 tags", GATE_PROFILE_FAMOUSO, Direction::ingress, kEff | GATE_REPLY_ID,
         false, true, 16},
    Case{"famouso reply, 4096 tags", GATE_PROFILE_FAMOUSO, Direction::ingress, kEff | GATE_REPLY_ID,
         false, true, GATE_BINDINGS},
    Case{"j1939 pass", GATE_PROFILE_J1939, Direction::egress, kEff | 0x18feca21, true},
    Case{"j1939 drop", GATE_PROFILE_J1939, Direction::ingress, kEff | 0x18fecb21, false},
    Case{"cyphal pass", GATE_PROFILE_CYPHAL, Direction::egress, kEff | 0x107d552a, true},
    Case{"cyphal drop", GATE_PROFILE_CYPHAL, Direction::ingress, kEff | 0x107d542a, false},
    Case{"canopen pass", GATE_PROFILE_CANOPEN, Direction::egress, 0x181, true},
    Case{"canopen pass by a mask", GATE_PROFILE_CANOPEN, Direction::egress, 0x701, true},
    Case{"canopen drop", GATE_PROFILE_CANOPEN, Direction::ingress, 0x182, false},
    Case{"echo of a local frame", GATE_PROFILE_RAW, Direction::ingress, 0x123, true},
    Case{"raw dense pass, portable loads", GATE_PROFILE_RAW, Direction::egress, 0x123, true, false},
    Case{"raw dense pass, policed", GATE_PROFILE_RAW, Direction::egress, 0x125, true},
    Case{"raw dense pass, watched", GATE_PROFILE_RAW, Direction::egress, 0x127, true},
    Case{"raw dense pass, policed and watched", GATE_PROFILE_RAW, Direction::egress, 0x128, true},
    Case{"raw dense excess, dropped", GATE_PROFILE_RAW, Direction::egress, 0x126, true},
};

SlotSpec policed(SlotSpec s, std::uint64_t per_frame, std::uint64_t tolerance) {
  s.per_frame = per_frame;
  s.tolerance = tolerance;
  return s;
}

SlotSpec watched(SlotSpec s, std::uint64_t period) {
  s.period = period;
  return s;
}

void fill(LoadedGate& gate, std::uint32_t profile) {
  constexpr std::uint64_t hour = 3'600'000'000'000;  // ns
  if (profile == GATE_PROFILE_RAW) {
    // One that is always in turn, and one that never is again.
    gate.admit({policed(slot(Direction::egress, 0x125, true), 1, hour),
                policed(slot(Direction::egress, 0x126, true), hour, 0),
                watched(slot(Direction::egress, 0x127, true), hour),
                watched(policed(slot(Direction::egress, 0x128, true), 1, hour), hour)});
    gate.admit({slot(Direction::egress, 0x123, true), slot(Direction::ingress, 0x124, false),
                slot(Direction::egress, kEff | 0x1abcdef, true)});
    return;
  }
  // What passes on egress; the neighbour that is dropped on ingress has a slot that denies.
  const auto pair = [&](std::uint32_t pass, std::uint32_t drop) {
    gate.admit({slot(Direction::egress, pass, true), slot(Direction::ingress, drop, false)});
  };
  if (profile == GATE_PROFILE_J1939) return pair(kEff | 0x18feca21, kEff | 0x18fecb21);
  if (profile == GATE_PROFILE_CYPHAL) return pair(kEff | 0x107d552a, kEff | 0x107d542a);
  if (profile == GATE_PROFILE_CANOPEN) {
    auto error_control = slot(Direction::egress, 0x700, true);
    error_control.mask &= ~0x7fU;
    gate.admit({error_control});
    return pair(0x181, 0x182);
  }
  gate.admit(
      {slot(Direction::egress, kEff | 0x64, true), slot(Direction::ingress, kEff | 0x65, false)});
  constexpr std::uint32_t publishers = 8;  // half of GATE_CHAIN
  for (std::uint32_t node = 0; node < publishers; ++node)
    gate.admit({slot(Direction::egress, kEff | node << 14 | 0x66, true)});
}

double time_of(const Case& c) {
  auto& gate = LoadedGate::with({.profile = c.profile, .direct_access = c.direct_access});
  fill(gate, c.profile);
  std::vector<gates::StatedBinding> stated;
  for (std::uint16_t i = 0; i < c.bindings; ++i)
    stated.push_back({.subject = i + 1U, .etag = static_cast<std::uint16_t>(0x64 + i)});
  gates::Bindings(gate.table()).state(stated);
  const Sender sender{.local = c.local};
  return nanoseconds_of([&](int repeat) { gate.time(c.direction, frame(c.id, 8), sender, repeat); },
                        c.bindings != 0 ? kRepeat / 100 : kRepeat);
}

/// A step of one verdict.
void step(__u8 (&halves)[2], std::uint32_t& generation, std::uint8_t verdict) {
  const std::uint32_t next = generation + 1;
  __atomic_store_n(&halves[next & 1], verdict, __ATOMIC_RELEASE);
  __atomic_store_n(&generation, next, __ATOMIC_RELEASE);
  __atomic_store_n(&halves[~next & 1], verdict, __ATOMIC_RELEASE);
}

/// Flip of one verdict of a table with many slots: three stores, and the look-up of the slot before
/// it.
double verdict_flip(bool with_lookup) {
  auto& gate = LoadedGate::with();
  for (std::uint32_t id = 0; id < 1000; ++id) gate.admit({slot(Direction::egress, id, true)});
  const auto spec = slot(Direction::egress, 500, true);
  auto& verdict = gate.table().slots[gate.slots().find(spec).value()].verdict;
  auto& generation = gate.control().generation;
  gates::SlotChanges close;
  gates::SlotChanges open;
  close.close = open.open = {spec};
  return nanoseconds_of(
      [&](int repeat) {
        for (int i = 0; i < repeat; ++i) {
          if (!with_lookup)
            step(verdict, generation, static_cast<std::uint8_t>(i & 1));
          else if (!gate.slots().apply((i & 1) != 0 ? open : close))
            std::abort();
        }
      },
      2'000);
}

double map_update() {
  const Fd map(
      bpf_map_create(BPF_MAP_TYPE_ARRAY, "bench", 4, sizeof(gate_slot), GATE_SLOTS, nullptr));
  const std::uint32_t key = 500;
  gate_slot value{};
  return nanoseconds_of(
      [&](int repeat) {
        for (int i = 0; i < repeat; ++i) {
          value.verdict[0] = static_cast<std::uint8_t>(i & 1);
          if (bpf_map_update_elem(map.get(), &key, &value, BPF_ANY) != 0) std::abort();
        }
      },
      2'000);
}

void print() {
  const double empty = empty_program_ns();
  std::string rows;
  for (const auto& c : kCases) {
    const double ns = time_of(c);
    rows += fmt::format(
        "    {{\"name\": \"{}\", \"ns\": {:.1f}, \"above_empty_ns\": {:.1f}, \"ratio\": "
        "{:.2f}}},\n",
        c.name, ns, ns - empty, ns / empty);
  }
  rows.erase(rows.size() - 2, 1);
  const double store = verdict_flip(false);
  const double apply = verdict_flip(true);
  const double update = map_update();
  fmt::print(
      "{{\n  \"frame\": {{\"floor\": \"empty tc program\", \"floor_ns\": {:.1f}, \"cases\": [\n",
      empty);
  fmt::print("{}  ]}},\n", rows);
  fmt::print(
      "  \"verdict_flip\": {{\"floor\": \"one map-update system call\", \"floor_ns\": {:.1f}, "
      "\"store_ns\": {:.1f}, \"apply_ns\": {:.1f}, \"store_ratio\": {:.4f}, \"apply_ratio\": "
      "{:.3f}}}\n}}\n",
      update, store, apply, store / update, apply / update);
}

}  // namespace
}  // namespace mlcca::test

int main() {
  mlcca::test::print();
  return 0;
}
