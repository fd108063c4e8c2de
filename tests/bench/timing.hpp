// SPDX-License-Identifier: BSD-2-Clause
// What benches of BPF programs have in common.
#pragma once
#include <bpf/bpf.h>
#include <linux/pkt_cls.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "base/handle.hpp"

namespace mlcca::test {

/// ns of one of `repeat` repetitions, in the best of so many runs: the others were disturbed. The
/// kernel's own figure is in whole ns: the time of the whole call is finer.
double best_of(int runs, int repeat, const auto& work) {
  using Clock = std::chrono::steady_clock;
  double best = 1e9;
  for (int run = 0; run < runs; ++run) {
    const auto start = Clock::now();
    work(repeat);
    const std::chrono::duration<double, std::nano> took = Clock::now() - start;
    best = std::min(best, took.count() / repeat);
  }
  return best;
}

/// A tc program that passes everything: the floor.
inline Fd empty_program() {
  std::array<bpf_insn, 2> program{};
  program[0].code = BPF_ALU64 | BPF_MOV | BPF_K;
  program[0].imm = TC_ACT_UNSPEC;
  program[1].code = BPF_JMP | BPF_EXIT;
  return Fd(bpf_prog_load(BPF_PROG_TYPE_SCHED_CLS, "empty", "GPL", program.data(), 2, nullptr));
}

}  // namespace mlcca::test
