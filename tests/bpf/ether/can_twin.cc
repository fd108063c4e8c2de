// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bpf/ether/can_twin.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <gate_test.skel.h>
#include <linux/pkt_cls.h>

#include <cstring>

#include "tests/support/require.hpp"

namespace mlcca::test {
CanTwin::CanTwin(int control_map) : object_(gate_test_bpf__open(), gate_test_bpf__destroy) {
  require(object_ != nullptr, "open the CAN gate");
  object_->rodata->profile = GATE_PROFILE_RAW;
  bpf_map__set_max_entries(object_->maps.cpus,
                           static_cast<std::uint32_t>(libbpf_num_possible_cpus()));
  require(bpf_map__reuse_fd(object_->maps.data_control, control_map) == 0, "share the control");
  require(gate_test_bpf__load(object_.get()) == 0, "load the CAN gate");
  auto table =
      gates::SlotTable::read({object_->bss->table, {}, object_->data_control->control.generation},
                             GATE_PROFILE_RAW, true, [] { return Result<void>{}; });
  require(table.has_value(), "read the slots");
  table_ = std::make_unique<gates::SlotTable>(std::move(*table));
}

gates::SlotSpec CanTwin::slot(std::uint32_t id, bool pass) {
  gates::SlotSpec s;
  s.pass = pass;
  s.id = id;
  s.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;
  s.subject = id;
  return s;
}

void CanTwin::admit(const std::vector<gates::SlotSpec>& specs) {
  gates::SlotChanges changes;
  changes.add = specs;
  require(table_->apply(changes).has_value(), "add slots");
}

bool CanTwin::passes(std::uint32_t id) const {
  can_frame frame{};
  frame.can_id = id;
  frame.len = 8;
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = &frame;
  run.data_size_in = sizeof(frame);
  require(bpf_prog_test_run_opts(bpf_program__fd(object_->progs.gate_ingress), &run) == 0,
          "run a frame");
  return static_cast<int>(run.retval) == TC_ACT_UNSPEC;
}

}  // namespace mlcca::test
