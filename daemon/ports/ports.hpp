// SPDX-License-Identifier: BSD-2-Clause
// The interfaces of this gateway: which of those that are there belong to which network, their
// gates, and what the gates hold.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
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
#include "daemon/gates/slot_spec.hpp"
#include "daemon/net/identity.hpp"
#include "daemon/net/links.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/ports/drift.hpp"
#include "daemon/ports/former_gates.hpp"
#include "daemon/ports/gate_set.hpp"
#include "daemon/ports/kernel_gate.hpp"
#include "daemon/ports/report_line.hpp"
#include "daemon/ports/vanished_gates.hpp"

namespace mlcca {

class Ports final : public GateDriver {
 public:
  /// `root`: the bpffs of `control`.
  Ports(net::Links& links, enforce::Control& control, std::string root, net::FactsOf facts_of,
        ReportLine report, Drift::Report report_drift)
      : links_(links),
        control_(control),
        root_(std::move(root)),
        facts_of_(std::move(facts_of)),
        report_(std::move(report)),
        gates_([this](const GateSpec& spec) { return KernelGate::load(spec, control_); }),
        former_(report_),
        drift_(std::move(report_drift)) {}

  /// The ports of a new description. Gates that are there stay as they are until follow() and
  /// sync(); an interface that is not described any more is closed by follow().
  void describe(const core::System& system, std::size_t gateway) override;

  /// Before describe(): makes all gates that this description needs and that are not there, without
  /// putting any in place. Until end_change() the gates that they displace are kept as well, for
  /// the way back. Error: there is no memory for one, or no right; nothing was changed.
  Result<void> prepare(const core::System& system, std::size_t gateway) override;
  /// Why a gate could not be put in place since prepare(): describe() what was before, and
  /// follow(). The one that was in its place is there, with its slots.
  [[nodiscard]] const Result<void>& change() const override { return gates_.change(); }
  /// From now on follow() and sync() go back to what was before.
  void go_back() override { gates_.go_back(); }
  void end_change() override { gates_.end_change(); }

  /// Called between the steps of what takes long, a gate at a time.
  void on_step(std::function<void()> step) override { step_ = std::move(step); }

  [[nodiscard]] bool needs_reconcile() override;
  /// Brings gates and interfaces in line with what is there now: bit rate, then gate, then up.
  /// Everything that changed hands is denied before anything else happens.
  void follow() override;

  /// Gates that lost their filters get them back; one that could not be attached is tried again.
  /// True if that changed anything: follow() then.
  bool repair() override;
  /// The same in steps, a gate at a time: what comes before them, then next_gate() behind 0 and so
  /// on, then wants_gate() returns what repair() would.
  void begin_repair() override;
  /// False where the gate is gone and cannot be put back: follow() at once, before anything else.
  bool repair(int ifindex) override;
  [[nodiscard]] bool wants_gate() const override;
  /// The gate behind this one, by ifindex; nothing behind the last one.
  [[nodiscard]] std::optional<int> next_gate(int ifindex) const override {
    return gates_.next(ifindex);
  }

  /// An interface that ought to be gated has no gate that we command, and an older one may still
  /// pass what it holds: everything must be closed.
  [[nodiscard]] bool out_of_hand() const override;
  /// Whether a gate's interface is there could not be found out: follow() again soon.
  [[nodiscard]] bool needs_recheck() const override {
    return vanished_.unconfirmed() || former_.needs_recheck();
  }

  /// Why it is unknown whether gates without pins are left; empty: it is known.
  [[nodiscard]] const std::string& orphans_unknown() const override {
    return former_.orphans_unknown();
  }

  /// Once a second: frames that were sent past the gate of an interface.
  void check_bypass(int ifindex, std::int64_t now_s) override;

  /// Usable or why not, per network of the system.
  [[nodiscard]] std::vector<core::Condition> conditions(std::size_t networks) const override;

  /// What the bus behind a port has carried; nothing where the kernel does not say.
  [[nodiscard]] std::optional<BusCounters> bus_counters(std::size_t port) override;
  /// Makes every gate hold exactly `wanted`. A gate that refuses is denied as a whole, and the
  /// error names it.
  Result<void> sync(const core::GateState& wanted) override;
  /// What leaves through a port is queued by these limits, see enforce::Gate::set_bands().
  void set_bands(std::size_t port, std::span<const std::uint32_t> limits) override;
  /// Makes the changes. After an error gates hold part of them: sync() then.
  Result<void> apply(const core::GateChanges& changes) override;

  /// What the gates hold of these rules, in their order.
  [[nodiscard]] std::vector<enforce::PlacedSlot> slots(
      std::span<const core::GateRule> rules) const override;

  /// What came and left by these rules. A frame that leaves has passed once: it is counted where it
  /// leaves, or, where that entry is one of those `shared` with others, where it came in.
  [[nodiscard]] Frames frames(const core::GateState& rules,
                              const std::vector<core::GateEntry>& shared) const override;
  using GateDriver::frames;
  /// How the events of a delivery come to the slot that they enter by; nothing where it is not
  /// watched.
  [[nodiscard]] std::optional<control::Watch> watch(const core::GateState& rules) const override;
  /// If events of a delivery are missing that is reported once more, for a client that has not
  /// received it.
  [[nodiscard]] Result<void> report_again(const core::GateState& rules) const override;
  /// The event is of the slot that one of these rules is held by.
  [[nodiscard]] bool is_of(const gate_event& event, const core::GateState& rules) const override;
  [[nodiscard]] std::vector<control::Interface> report() const override;
  [[nodiscard]] std::size_t size() const override { return ports_.size(); }
  /// The gate of a port; none where it needs none or could not be attached.
  [[nodiscard]] const enforce::PortGate* gate(std::size_t port) const { return gate_of(port); }
  /// The same where it is a CAN gate.
  [[nodiscard]] enforce::Gate* can_gate(std::size_t port) const { return can_gate_of(port); }
  [[nodiscard]] const core::Port& described(std::size_t port) const override {
    return ports_[port].port;
  }
  [[nodiscard]] bool is_can(std::size_t port) const {
    return ports_[port].kind == core::NetworkKind::can;
  }
  [[nodiscard]] core::Profile profile(std::size_t port) const override {
    return ports_[port].profile;
  }
  [[nodiscard]] const std::string& problem(std::size_t port) const override {
    return ports_[port].problem;
  }
  [[nodiscard]] const std::string& network_of(std::size_t port) const override {
    return ports_[port].network_name;
  }
  /// Of the interface that is held by a gate, 0: there is none.
  [[nodiscard]] int gated_interface(std::size_t port) const override {
    return gate_of(port) == nullptr ? 0 : ports_[port].ifindex;
  }
  /// Frames without a slot so far, on one port.
  [[nodiscard]] UnknownFrames unknown_frames(std::size_t port) const override;
  /// The latest frame without a slot that came in: "123", "0x4e6f626f64790000 from 10.0.0.7".
  [[nodiscard]] std::string latest_unknown(std::size_t port) const override;
  [[nodiscard]] control::Gates gates(const core::State& state,
                                     const std::string& place) const override;
  [[nodiscard]] std::string gated_places() const override;
  [[nodiscard]] std::size_t slot_count() const override;
  [[nodiscard]] std::optional<enforce::Bindings> bindings(std::size_t port) const override;
  /// Name of the interface now, or what it is recognised by.
  [[nodiscard]] std::string interface_name(std::size_t port) const override;

 private:
  struct PortState {
    core::Port port;
    std::string network_name;
    core::NetworkKind kind = core::NetworkKind::can;
    core::Profile profile = core::Profile::none;
    std::uint32_t described_bitrate = 0;  ///< of the network
    std::string can_state;                ///< as last reported
    int ifindex = 0;                      ///< 0: not there
    std::string problem;
    std::optional<net::Link> followed;  ///< the interface as follow() has judged it
    bool unsettled = false;             ///< follow() has found what may be otherwise the next time
    bool raised = false;  ///< a managed interface was brought up once since it appeared
    bool lost = false;    ///< no gate of ours could be attached, not even a closed one
    int held = 0;  ///< ifindex that was given a gate without slots, because nothing else could be
    bool unfit = false;      ///< the gate that is there is of a former description, and is denied
    bool unwatched = false;  ///< its gate has more to watch than it can, and that was reported
    std::string reported;    ///< the last problem of attaching that was reported
  };

  static std::vector<PortState> ports_of(const core::System& system, std::size_t gateway);
  static std::size_t ether_slots_of(const core::System& system);
  [[nodiscard]] net::FactsOf facts_once() const;
  static bool needs_gate(const PortState& port);
  static bool is_gated_can(const PortState& port);
  static bool can_have_gate(const PortState& port, const net::Link& link);
  [[nodiscard]] const net::Link* link_of(const PortState& port) const;
  void match(PortState& port, const net::FactsOf& facts_of);
  void attach(PortState& port);
  void hold_by_former(PortState& port, const std::string& name);
  void hold_closed(PortState& port, const std::string& name);
  /// True if that changed the interface.
  bool raise(PortState& port);
  void forget_vanished();
  [[nodiscard]] bool concerns(const PortState& port, const net::FactsOf& facts_of) const;
  void close_undescribed();
  void judge(PortState& port);
  void queue(PortState& port);
  void report_can_state(PortState& port, const net::Link& link);
  /// Interface of its source port, 0: it has none; nothing: that is not there.
  [[nodiscard]] std::optional<std::uint32_t> source_of(const core::GateEntry& entry) const;
  [[nodiscard]] std::optional<enforce::SlotSpec> slot_of(const core::GateEntry& entry) const;
  [[nodiscard]] std::optional<enforce::SlotSpec> slot_of(const core::GateRule& rule) const;
  [[nodiscard]] std::map<std::size_t, enforce::SlotChanges> by_port(
      const core::GateChanges& changes) const;
  struct WatchedSlot {
    const enforce::PortGate* gate;
    std::uint32_t number;
    core::Watching expected;
  };
  void report_unwatched();
  [[nodiscard]] std::optional<WatchedSlot> watched_slot(const core::GateState& rules) const;
  [[nodiscard]] Drift::Gates all_gates() const;
  [[nodiscard]] HeldGate* held_by(std::size_t port) const;
  [[nodiscard]] enforce::PortGate* gate_of(std::size_t port) const;
  /// The gate of a port on a CAN network.
  [[nodiscard]] enforce::Gate* can_gate_of(std::size_t port) const;
  [[nodiscard]] bool is_to_be_gated(int ifindex) const;

  net::Links& links_;
  enforce::Control& control_;
  std::string root_;
  net::FactsOf facts_of_;
  ReportLine report_;
  std::function<void()> step_ = [] {};
  std::vector<PortState> ports_;
  std::size_t ether_slots_ = 0;  ///< that Ethernet gates must have room for
  GateSet gates_;
  VanishedGates vanished_;
  FormerGates former_;
  Drift drift_;
};

}  // namespace mlcca
