// SPDX-License-Identifier: BSD-2-Clause
// The ports of this gateway and their gates in the kernel. Combines the classes that know the
// ports, hold the gates, close what is left, fill the slots, and report.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/admission.hpp"
#include "core/gates/plan.hpp"
#include "core/model/system.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/net/identity.hpp"
#include "daemon/net/links.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/ports/delivery_frames.hpp"
#include "daemon/ports/drift.hpp"
#include "daemon/ports/former_gates.hpp"
#include "daemon/ports/gate_report.hpp"
#include "daemon/ports/gate_slots.hpp"
#include "daemon/ports/gated_ports.hpp"
#include "daemon/ports/port_report.hpp"
#include "daemon/ports/report_line.hpp"
#include "daemon/ports/vanished_gates.hpp"
#include "daemon/ports/watched_slots.hpp"

namespace mlcca {

class Ports final : public GateDriver {
 public:
  Ports(net::Links& links, gates::Control& control, net::FactsOf facts_of, ReportLine report,
        Drift::Report report_drift);

  // Ports, interfaces and gates:

  void describe(const core::System& system, std::size_t gateway) override {
    ports_.describe(system, gateway);
  }
  Result<void> prepare(const core::System& system, std::size_t gateway) override;
  void go_back() override { ports_.gates().go_back(); }
  void end_change() override { ports_.gates().end_change(); }
  void on_step(std::function<void()> step) override { step_ = std::move(step); }
  [[nodiscard]] bool needs_reconcile() override;
  Result<void> follow() override;
  bool repair() override;
  void begin_repair() override;
  bool repair(int ifindex) override;
  [[nodiscard]] bool wants_gate() const override { return ports_.wants_gate(links_.table()); }
  [[nodiscard]] std::optional<int> next_gate(int ifindex) const override {
    return ports_.gates().next(ifindex);
  }
  [[nodiscard]] bool out_of_hand() const override {
    return former_.unread() || ports_.is_any_lost();
  }
  [[nodiscard]] bool needs_recheck() const override {
    return vanished_.unconfirmed() || former_.needs_recheck();
  }
  [[nodiscard]] const std::string& orphans_unknown() const override {
    return former_.orphans_unknown();
  }
  [[nodiscard]] std::vector<std::string> undescribed() const override;
  void check_bypass(int ifindex, std::int64_t now_s) override;

  // Slots:

  Result<void> sync(const core::GateState& wanted) override;
  Result<void> apply(const core::GateChanges& changes) override;
  void set_bands(std::size_t port, std::span<const std::uint32_t> limits) override;
  [[nodiscard]] std::vector<gates::PlacedSlot> slots(
      std::span<const core::GateRule> rules) const override {
    return placed_slots(rules, ports_);
  }
  using GateDriver::frames;
  [[nodiscard]] Frames frames(const core::GateState& rules,
                              const std::vector<core::GateEntry>& shared) const override {
    return delivery_frames(rules, shared, ports_);
  }
  [[nodiscard]] std::optional<control::Watch> watch(const core::GateState& rules) const override {
    return watch_of(rules, ports_);
  }
  [[nodiscard]] Result<void> report_again(const core::GateState& rules) const override {
    return report_missing_again(rules, ports_);
  }
  [[nodiscard]] bool is_of(const gate_event& event, const core::GateState& rules) const override {
    return mlcca::is_of(event, rules, ports_);
  }
  [[nodiscard]] control::Gates gates(const core::State& state,
                                     const std::string& place) const override {
    return gate_reports(ports_, links_.table(), state, place);
  }
  [[nodiscard]] std::string gated_places() const override {
    return mlcca::gated_places(ports_, links_.table());
  }
  [[nodiscard]] std::size_t slot_count() const override { return mlcca::slot_count(ports_); }

  // One port:

  [[nodiscard]] std::size_t size() const override { return ports_.size(); }
  [[nodiscard]] const core::Port& described(std::size_t port) const override {
    return ports_[port].described();
  }
  [[nodiscard]] core::Profile profile(std::size_t port) const override {
    return ports_[port].profile();
  }
  [[nodiscard]] const std::string& network_of(std::size_t port) const override {
    return ports_[port].network();
  }
  [[nodiscard]] std::string interface_name(std::size_t port) const override {
    return ports_[port].interface_name(links_.table());
  }
  [[nodiscard]] int gated_interface(std::size_t port) const override {
    return ports_.has_gate(port) ? ports_[port].ifindex() : 0;
  }
  [[nodiscard]] const std::string& problem(std::size_t port) const override {
    return ports_[port].problem();
  }
  /// nullptr if the port needs no gate, or it could not be attached.
  [[nodiscard]] const gates::PortGate* gate(std::size_t port) const { return ports_.gate(port); }
  [[nodiscard]] std::vector<core::Condition> conditions(std::size_t networks) const override;
  [[nodiscard]] std::optional<BusCounters> bus_counters(std::size_t port) override;
  [[nodiscard]] UnknownFrames unknown_frames(std::size_t port) const override {
    return mlcca::unknown_frames(gate(port));
  }
  [[nodiscard]] std::vector<gates::UnknownFrame> seen_unknown(std::size_t port) const override {
    const gates::PortGate* const of_port = gate(port);
    return of_port == nullptr ? std::vector<gates::UnknownFrame>() : of_port->unknown();
  }
  [[nodiscard]] std::vector<gates::RefusedSender> refused_senders(std::size_t port) const override {
    const gates::PortGate* const of_port = gate(port);
    return of_port == nullptr ? std::vector<gates::RefusedSender>() : of_port->refused_senders();
  }
  [[nodiscard]] std::optional<std::uint32_t> slot_number(
      const core::GateEntry& entry) const override {
    return slot_number_of(entry, ports_);
  }
  [[nodiscard]] std::vector<Refusals> refusals(std::size_t port) const override {
    return mlcca::refusals(gate(port));
  }
  [[nodiscard]] std::vector<WithoutSlot> without_slot(std::size_t port) const override {
    return mlcca::without_slot(gate(port));
  }
  [[nodiscard]] std::vector<Refusals> misfits(std::size_t port) const override {
    return mlcca::misfits(gate(port));
  }
  [[nodiscard]] std::string latest_unknown(std::size_t port) const override {
    return mlcca::latest_unknown(gate(port));
  }
  [[nodiscard]] std::optional<gates::Bindings> bindings(std::size_t port) const override;
  [[nodiscard]] std::vector<control::Interface> report() const override {
    return port_reports(ports_, links_, drift_);
  }

 private:
  void forget_vanished();
  void match();
  void close_undescribed();
  void report_undescribed();
  Result<void> attach();
  void assess();
  [[nodiscard]] std::vector<std::string> closed() const;
  bool give_up(int ifindex, gates::PortGate& gate);
  [[nodiscard]] net::Presence presence(int ifindex) { return links_.presence(ifindex); }

  net::Links& links_;
  gates::Control& control_;
  net::FactsOf facts_of_;
  ReportLine report_;
  std::function<void()> step_ = [] {};
  GatedPorts ports_;
  VanishedGates vanished_;
  std::vector<std::string> reported_undescribed_;
  FormerGates former_;
  Drift drift_;
};

}  // namespace mlcca
