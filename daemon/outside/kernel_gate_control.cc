// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/outside/kernel_gate_control.hpp"

#include <utility>

#include "daemon/gates/interrupted.hpp"

namespace mlcca {

Result<void> KernelGateControl::begin_start(std::uint64_t limit, std::uint64_t now) {
  auto begun = gates::Starting::begin(control_, limit, now);
  if (!begun) return std::unexpected(begun.error());
  starting_.emplace(std::move(*begun));
  return {};
}

void KernelGateControl::beat_while_starting(std::uint64_t now) {
  if (starting_) starting_->beat(control_, now);
}

Result<void> KernelGateControl::undo_interrupted_step() {
  return gates::undo_interrupted_step(control_);
}

void KernelGateControl::end_start() {
  control_.take_over();
  if (starting_) starting_->finish();
}

Result<void> KernelGateControl::listen(GateReports reports) {
  auto reader = gates::EventReader::open(control_.events_fd(),
                                         {std::move(reports.event), std::move(reports.sample)});
  if (!reader) return std::unexpected(reader.error());
  reports_.emplace(std::move(*reader));
  return {};
}

}  // namespace mlcca
