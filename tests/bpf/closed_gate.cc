// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bpf/closed_gate.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <gate_closed_test.skel.h>
#include <linux/pkt_cls.h>

#include "tests/support/require.hpp"

namespace mlcca::test {
ClosedGate::ClosedGate(int control_map)
    : object_(gate_closed_test_bpf__open(), gate_closed_test_bpf__destroy) {
  require(object_ != nullptr, "open the closed gate");
  require(bpf_map__reuse_fd(object_->maps.data_control, control_map) == 0, "share the control");
  require(gate_closed_test_bpf__load(object_.get()) == 0, "load the closed gate");
}

bool ClosedGate::drops(gates::Direction direction, const Bytes& bytes, const Sender& sender) const {
  __sk_buff context{};
  context.priority = priority_of(sender);
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = bytes.data();
  run.data_size_in = static_cast<std::uint32_t>(bytes.size());
  run.ctx_in = &context;
  run.ctx_size_in = sizeof(context);
  const auto* program = direction == gates::Direction::ingress ? object_->progs.closed_ingress
                                                               : object_->progs.closed_egress;
  require(bpf_prog_test_run_opts(bpf_program__fd(program), &run) == 0, "run a frame");
  return static_cast<int>(run.retval) == TC_ACT_SHOT;
}

}  // namespace mlcca::test
