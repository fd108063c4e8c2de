// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/events.hpp"
#include "daemon/gates/starting.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

/// The control word that all gates in the kernel read, and the ring to which they report.
class KernelGateControl final : public GateControl {
 public:
  explicit KernelGateControl(gates::Control control) : control_(std::move(control)) {}

  /// For the code that attaches gates to it.
  [[nodiscard]] gates::Control& control() { return control_; }

  void open() override { control_.open(); }
  void close_all() override { control_.close_all(); }
  [[nodiscard]] bool is_open() const override { return control_.is_open(); }
  void set_mode(gates::Mode mode) override { control_.set_mode(mode); }
  [[nodiscard]] gates::Mode mode() const override { return control_.mode(); }
  Result<void> set_grace(std::uint64_t grace) override { return control_.set_grace(grace); }
  [[nodiscard]] std::uint64_t grace() const override { return control_.grace(); }
  Result<void> set_until(std::uint64_t until) override { return control_.set_until(until); }
  [[nodiscard]] std::uint64_t until() const override { return control_.until(); }
  Result<void> beat(std::uint64_t now) override { return control_.beat(now); }
  [[nodiscard]] std::uint64_t beat_interval() const override { return control_.beat_interval(); }
  [[nodiscard]] bool lapsed() const override { return control_.lapsed(); }
  [[nodiscard]] std::uint64_t lapses() const override { return control_.lapses(); }
  Result<void> clear_lapse(std::uint64_t now) override { return control_.clear_lapse(now); }
  Result<void> begin_start(std::uint64_t limit, std::uint64_t now) override;
  void beat_while_starting(std::uint64_t now) override;
  Result<void> undo_interrupted_step() override;
  void end_start() override;
  Result<void> arm() override { return control_.arm(); }
  Result<bool> keep_pinned() override { return control_.keep_pinned(); }
  std::vector<std::string> take_replaced() override { return control_.take_replaced(); }
  bool keep_epoch() override { return control_.keep_epoch(); }
  Result<bool> keep_grace() override { return control_.keep_grace(); }
  Result<void> listen(GateReports reports) override;
  [[nodiscard]] int reports_fd() const override { return reports_->fd(); }
  Result<void> read_reports() override { return reports_->read(); }

 private:
  gates::Control control_;
  std::optional<gates::Starting> starting_;
  std::optional<gates::EventReader> reports_;
};

}  // namespace mlcca
