// SPDX-License-Identifier: BSD-2-Clause
// Loads the skeleton for test runs.
#include "tests/bpf/ether/loaded_ether.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <ether_test.skel.h>
#include <linux/pkt_cls.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>

#include "daemon/gates/programs.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint32_t kTestRunLocal = 1;  // TEST_RUN_LOCAL of test_skb.bpf.h

template <class T>
T require(T value, const char* what) {
  if (!value) {
    std::perror(what);
    std::abort();
  }
  return value;
}

template <class T>
gates::Mapped<T> mapped(const bpf_map* map) {
  gates::Mapped<T> memory(bpf_map__fd(map), bpf_map__max_entries(map));
  require(static_cast<bool>(memory), "map memory");
  return memory;
}

void clear(const bpf_map* map) {
  ether_fragment_key key{};
  while (bpf_map_get_next_key(bpf_map__fd(map), nullptr, &key) == 0)
    bpf_map_delete_elem(bpf_map__fd(map), &key);
}

}  // namespace

LoadedEther::LoadedEther(const EtherOptions& options)
    : sizes_(gates::EtherSizes::for_slots(options.slots,
                                          static_cast<std::uint32_t>(libbpf_num_possible_cpus()))),
      object_(require(ether_test_bpf__open(), "open the gate"), ether_test_bpf__destroy) {
  auto* knobs = object_->rodata;
  knobs->ifindex = kIfindex;
  knobs->direct_access = options.direct_access;
  knobs->atomic_counts = options.atomic_counts;
  knobs->ordered_stores = gates::kOrderedStores && !options.atomic_counts;
  knobs->bucket_mask = sizes_.buckets - 1;
  knobs->slots_of_bank = sizes_.slots;
  knobs->banks = sizes_.banks;
  knobs->has_prefilter = sizes_.has_prefilter();
  knobs->is_wpan = options.wpan;
  const auto& maps = object_->maps;
  bpf_map__set_max_entries(maps.buckets, sizes_.buckets);
  bpf_map__set_max_entries(maps.ether_prefilter, sizes_.prefilters());
  bpf_map__set_max_entries(maps.slots, sizes_.slots);
  bpf_map__set_max_entries(maps.contracts, sizes_.contracts);
  bpf_map__set_max_entries(maps.counts, sizes_.banks * sizes_.slots);
  const auto cpus = static_cast<std::uint32_t>(libbpf_num_possible_cpus());
  bpf_map__set_max_entries(maps.cpus, cpus);
  bpf_map__set_max_entries(maps.fragments, ether_fragment_entries(cpus));
  bpf_map__set_max_entries(maps.foreign_fragments, ether_fragment_entries(cpus));
  bpf_map__set_max_entries(maps.watches, ETHER_WATCHES);
  bpf_map__set_max_entries(maps.audits, sizes_.slots);
  require(ether_test_bpf__load(object_.get()) == 0, "load the gate");
  buckets_ = mapped<std::uint64_t>(maps.buckets);
  prefilters_ = mapped<ether_prefilter_part>(maps.ether_prefilter);
  slots_ = mapped<ether_slot>(maps.slots);
  contracts_ = mapped<ether_contract>(maps.contracts);
  counts_ = mapped<gate_count>(maps.counts);
  audits_ = mapped<gate_audit>(maps.audits);
  cpus_ = mapped<ether_cpu>(maps.cpus);
  watches_ = mapped<gate_watch>(maps.watches);
  memory_ = {.table = &object_->bss->table,
             .buckets = buckets_.span(),
             .prefilters = prefilters_.span(),
             .slots = slots_.span(),
             .contracts = contracts_.span(),
             .counts = counts_.span(),
             .audits = audits_.span(),
             .watches = watches_.span(),
             .generation = &object_->data_control->control.generation};
  reset();
}

LoadedEther& LoadedEther::with(const EtherOptions& options) {
  static std::map<EtherOptions, std::unique_ptr<LoadedEther>> loaded;
  auto& gate = loaded[options];
  if (gate)
    gate->reset();
  else
    gate = std::make_unique<LoadedEther>(options);
  return *gate;
}

void LoadedEther::reset() {
  std::memset(memory_.buckets.data(), 0, memory_.buckets.size_bytes());
  std::memset(memory_.prefilters.data(), 0, memory_.prefilters.size_bytes());
  std::memset(memory_.counts.data(), 0, memory_.counts.size_bytes());
  std::memset(memory_.audits.data(), 0, memory_.audits.size_bytes());
  for (auto& cpu : cpus()) cpu = {};
  for (std::size_t own = 0; own < ETHER_FIRST_SLOT; ++own) memory_.slots[own] = {};
  clear(object_->maps.fragments);
  clear(object_->maps.foreign_fragments);
  control() = {};
  control().layout_version = GATE_LAYOUT_VERSION;
  control().open = 1;
  control().deadline = ~0ULL;
  control().token = kToken;
  auto table = gates::EtherTable::read(memory_, sizes_, true, 0x1234567890abcdef,
                                       [] { return Result<void>{}; });
  require(table.has_value(), "read the table");
  table_ = std::make_unique<gates::EtherTable>(std::move(*table));
}

int LoadedEther::control_fd() const { return bpf_map__fd(object_->maps.data_control); }

gate_control& LoadedEther::control() const { return object_->data_control->control; }

int LoadedEther::program_fd(gates::Direction direction) const {
  return bpf_program__fd(direction == gates::Direction::ingress ? object_->progs.ether_ingress
                                                                : object_->progs.ether_egress);
}
int LoadedEther::early_fd() const { return bpf_program__fd(object_->progs.ether_early); }

Outcome LoadedEther::run(gates::Direction direction, const Bytes& bytes,
                         const Sender& sender) const {
  __sk_buff context{};
  context.priority = sender.local ? kTestRunLocal : 0;
  context.mark = sender.mark;
  context.ingress_ifindex = sender.ingress_ifindex;
  context.gso_size = sender.segment;
  context.gso_segs = sender.segment != 0 ? 2 : 0;
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = bytes.data();
  run.data_size_in = static_cast<std::uint32_t>(bytes.size());
  run.ctx_in = &context;
  run.ctx_out = &context;
  run.ctx_size_in = run.ctx_size_out = sizeof(context);
  require(bpf_prog_test_run_opts(program_fd(direction), &run) == 0, "run a packet");
  require(run.retval == TC_ACT_SHOT || static_cast<int>(run.retval) == TC_ACT_UNSPEC, "an action");
  return {run.retval == TC_ACT_SHOT, context.mark};
}

void LoadedEther::repeat(gates::Direction direction, const Bytes& bytes, int times) const {
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = bytes.data();
  run.data_size_in = static_cast<std::uint32_t>(bytes.size());
  run.repeat = times;
  require(bpf_prog_test_run_opts(program_fd(direction), &run) == 0, "run a packet");
}

bool LoadedEther::dropped_early(const Bytes& bytes) const {
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = bytes.data();
  run.data_size_in = static_cast<std::uint32_t>(bytes.size());
  require(bpf_prog_test_run_opts(early_fd(), &run) == 0, "run a packet");
  require(run.retval == XDP_DROP || run.retval == XDP_PASS, "an action");
  return run.retval == XDP_DROP;
}

gates::SlotCounters LoadedEther::counted(const gates::SlotSpec& spec) const {
  return gates::ether_counters(memory_, table_->find(spec).value());
}
gates::SlotCounters LoadedEther::counted(gates::Direction direction) const {
  return gates::ether_counters(memory_, static_cast<std::uint32_t>(direction));
}
gates::ReasonCounters LoadedEther::reasons(gates::Direction direction) const {
  return gates::reason_counters(cpus(), direction);
}
gates::ReasonCounters LoadedEther::would_drop(gates::Direction direction) const {
  return gates::would_drop_counters(*memory_.table, direction);
}

std::size_t LoadedEther::map_bytes() const {
  std::size_t sum = 0;
  const bpf_map* map = nullptr;
  bpf_object__for_each_map(map, object_->obj) {
    std::ifstream info("/proc/self/fdinfo/" + std::to_string(bpf_map__fd(map)));
    for (std::string word; info >> word;) {
      if (word != "memlock:") continue;
      std::size_t bytes = 0;
      info >> bytes;
      sum += bytes;
    }
  }
  return sum;
}

void LoadedEther::admit(const std::vector<gates::SlotSpec>& specs) {
  gates::SlotChanges changes;
  changes.add = specs;
  const auto added = table_->apply(changes);
  if (!added) std::fprintf(stderr, "%s\n", added.error().text.c_str());
  require(added.has_value(), "add slots");
}

bool drops(const gates::ClosedPrograms& closed, gates::Direction direction, const Bytes& bytes) {
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = bytes.data();
  run.data_size_in = static_cast<std::uint32_t>(bytes.size());
  require(bpf_prog_test_run_opts(closed.program_fd(direction), &run) == 0, "run a packet");
  return static_cast<int>(run.retval) == TC_ACT_SHOT;
}

}  // namespace mlcca::test
