// SPDX-License-Identifier: BSD-2-Clause
// Loads the gate's skeleton for test runs.
#include "tests/bpf/loaded_gate.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <gate_test.skel.h>
#include <linux/pkt_cls.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

#include "daemon/gates/programs.hpp"

namespace mlcca::test {
namespace {

// TEST_RUN_LOCAL and TEST_RUN_XL of test_skb.bpf.h
constexpr std::uint32_t kTestRunLocal = 1;
constexpr std::uint32_t kTestRunXl = 2;

template <class T>
T require(T value, const char* what) {
  if (!value) {
    std::perror(what);
    std::abort();
  }
  return value;
}

}  // namespace

Bytes frame(std::uint32_t can_id, unsigned length, bool fd) {
  Bytes bytes(fd ? CANFD_MTU : CAN_MTU);
  std::memcpy(bytes.data(), &can_id, sizeof(can_id));
  bytes[4] = static_cast<std::uint8_t>(length);
  if (fd) bytes[5] = CANFD_FDF;
  return bytes;
}

Bytes xl_frame(std::uint32_t id, unsigned length, std::size_t lead) {
  constexpr std::size_t header = 12;  // of struct canxl_frame: id, flags, SDT, length, acceptance
  constexpr std::uint8_t xl_flag = 0x80;
  Bytes bytes(lead + header + length);
  const auto size = static_cast<std::uint16_t>(length);
  std::memcpy(&bytes[lead], &id, sizeof(id));
  bytes[lead + 4] = xl_flag;
  std::memcpy(&bytes[lead + 6], &size, sizeof(size));
  return bytes;
}

std::uint32_t priority_of(const Sender& sender) {
  return (sender.local ? kTestRunLocal : 0) | (sender.xl ? kTestRunXl : 0);
}

LoadedGate::LoadedGate(const GateOptions& options)
    : profile_(options.profile),
      object_(require(gate_test_bpf__open(), "open the gate"), gate_test_bpf__destroy) {
  auto* knobs = object_->rodata;
  knobs->profile = options.profile;
  knobs->ifindex = kIfindex;
  knobs->direct_access = options.direct_access;
  knobs->echo_by_mark = options.echo_by_mark;
  knobs->atomic_counts = options.atomic_counts;
  knobs->ordered_stores = gates::kOrderedStores && !options.atomic_counts;
  knobs->silent = options.silent;
  const auto cpus = static_cast<std::size_t>(libbpf_num_possible_cpus());
  bpf_map__set_max_entries(object_->maps.cpus, static_cast<std::uint32_t>(cpus));
  require(gate_test_bpf__load(object_.get()) == 0, "load the gate");
  cpus_ = {bpf_map__fd(object_->maps.cpus), cpus};
  require(static_cast<bool>(cpus_), "map the counters");
  reset();
}

LoadedGate& LoadedGate::with(const GateOptions& options) {
  static std::map<GateOptions, std::unique_ptr<LoadedGate>> loaded;
  auto& gate = loaded[options];
  if (gate)
    gate->reset();
  else
    gate = std::make_unique<LoadedGate>(options);
  return *gate;
}

void LoadedGate::reset() {
  table() = {};
  for (auto& cpu : cpus()) cpu = {};
  control() = {};
  control().layout_version = GATE_LAYOUT_VERSION;
  control().open = 1;
  control().deadline = ~0ULL;
  control().token = kToken;
  auto slots = gates::SlotTable::read({table(), cpus(), control().generation}, profile_, true,
                                      [] { return Result<void>{}; });
  require(slots.has_value(), "read the slots");
  slots_ = std::make_unique<gates::SlotTable>(std::move(*slots));
}

gate_table& LoadedGate::table() const { return object_->bss->table; }
gate_control& LoadedGate::control() const { return object_->data_control->control; }

bpf_test_run_opts LoadedGate::execute(gates::Direction direction, const Bytes& bytes,
                                      __sk_buff& context, const Sender& sender, int repeat) const {
  context.priority = priority_of(sender);
  context.mark = sender.mark;
  context.ingress_ifindex = sender.ingress_ifindex;
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = bytes.data();
  run.data_size_in = static_cast<std::uint32_t>(bytes.size());
  run.ctx_in = &context;
  run.ctx_out = &context;
  run.ctx_size_in = run.ctx_size_out = sizeof(context);
  run.repeat = repeat;
  auto* program = direction == gates::Direction::ingress ? object_->progs.gate_ingress
                                                         : object_->progs.gate_egress;
  require(bpf_prog_test_run_opts(bpf_program__fd(program), &run) == 0, "run a frame");
  return run;
}

int LoadedGate::control_fd() const { return bpf_map__fd(object_->maps.data_control); }

Outcome LoadedGate::run(gates::Direction direction, const Bytes& bytes,
                        const Sender& sender) const {
  __sk_buff context{};
  const auto run = execute(direction, bytes, context, sender, 0);
  require(run.retval == TC_ACT_SHOT || static_cast<int>(run.retval) == TC_ACT_UNSPEC, "an action");
  return {run.retval == TC_ACT_SHOT, context.mark};
}

int LoadedGate::action(gates::Direction direction, const Bytes& bytes, const Sender& sender) const {
  __sk_buff context{};
  return static_cast<int>(execute(direction, bytes, context, sender, 0).retval);
}

std::uint32_t LoadedGate::band(const Bytes& bytes, const Sender& sender) const {
  __sk_buff context{};
  const auto run = execute(gates::Direction::egress, bytes, context, sender, 0);
  require(static_cast<int>(run.retval) == TC_ACT_UNSPEC, "let a frame out");
  return context.priority;
}

std::uint32_t LoadedGate::time(gates::Direction direction, const Bytes& bytes, const Sender& sender,
                               int repeat) const {
  __sk_buff context{};
  return execute(direction, bytes, context, sender, repeat).duration;
}

void LoadedGate::admit(const std::vector<gates::SlotSpec>& specs) {
  for (const auto& spec : specs) {
    gates::SlotChanges changes;
    changes.add.push_back(spec);
    const auto added = slots_->apply(changes);
    if (!added) std::fprintf(stderr, "%s\n", added.error().text.c_str());
    require(added.has_value(), "add a slot");
  }
}

}  // namespace mlcca::test
