// SPDX-License-Identifier: BSD-2-Clause
// The gate of one Ethernet-like interface. Closing the object leaves it in the kernel as it is.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "daemon/gates/control.hpp"
#include "daemon/gates/port_gate.hpp"

namespace mlcca::enforce {

struct EtherConfig {
  std::uint32_t ifindex = 0;
  std::string name;          ///< for error texts
  std::size_t slots = 0;     ///< so many there must be room for
  std::optional<Hook> hook;  ///< the best one that the kernel has
  bool silent = false;       ///< as GateConfig::silent
};

class EtherGate final : public PortGate {
 public:
  /// As Gate::attach(): by replacement, never by detaching; slots and counters of the gate that is
  /// attached now are taken over, its slots alone where it is too small. Where the driver has XDP
  /// and nobody else's program is there, what is refused is dropped there. Error: no Ethernet
  /// interface.
  static Result<EtherGate> attach(const EtherConfig& config, const Control& control);
  /// As Gate::load().
  static Result<EtherGate> load(const EtherConfig& config, const Control& control);
  Result<void> put() override;
  EtherGate(EtherGate&&) noexcept;
  EtherGate& operator=(EtherGate&&) noexcept;
  ~EtherGate() override;

  /// It is as `config` wants it, and there is room for so many slots.
  [[nodiscard]] bool holds(const EtherConfig& config) const;
  /// The slots of the gate that was attached before were taken over: see present().
  [[nodiscard]] bool reused() const;

  [[nodiscard]] const std::string& name() const override;
  [[nodiscard]] std::uint32_t ifindex() const override;
  [[nodiscard]] Result<bool> attached() const override;
  Result<void> reattach() override;
  bool judge_again() override;
  [[nodiscard]] Hook hook() const override;
  [[nodiscard]] Result<std::vector<Ahead>> ahead() const override;
  Result<void> go_first() override;
  [[nodiscard]] bool judges_everything() const override { return false; }
  [[nodiscard]] std::uint32_t early() const override;
  [[nodiscard]] bool drops_early() const override;
  [[nodiscard]] bool lost_early() const override;
  Result<void> put_early_back() override;
  [[nodiscard]] std::vector<SlotSpec> present() const override;
  [[nodiscard]] std::size_t size() const override;
  [[nodiscard]] std::size_t room() const override;
  void deny_all() override;
  [[nodiscard]] Result<std::vector<std::string>> keep_pinned() const override;
  [[nodiscard]] std::optional<SlotCounters> counters(const SlotSpec& spec) const override;
  [[nodiscard]] std::optional<std::uint32_t> watched_as(const SlotSpec& spec) const override;
  [[nodiscard]] Arrivals arrivals(std::uint32_t slot, std::uint64_t now) const override;
  [[nodiscard]] Result<void> tell_again(std::uint32_t slot) const override;
  [[nodiscard]] std::size_t unwatched() const override;
  [[nodiscard]] ReasonCounters reasons(Direction direction) const override;
  [[nodiscard]] ReasonCounters would_drop(Direction direction) const override;
  [[nodiscard]] std::vector<UnknownFrame> unknown() const override;
  void unpin() override;

 private:
  [[nodiscard]] Table& table() override;
  [[nodiscard]] Result<void> arm(std::uint16_t watch) const override;

  struct State;
  explicit EtherGate(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Whether frames have Ethernet headers there; an error where the kernel does not say.
Result<bool> is_ethernet(std::uint32_t ifindex);

}  // namespace mlcca::enforce
