// SPDX-License-Identifier: BSD-2-Clause
// Fakes for everything outside of a gateway: interfaces that come and go, and gates that hold what
// is written to them or refuse it, without a kernel, a clock or threads. FakeKernel outlives a
// daemon; the other fakes are what one daemon sees of it.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "daemon/net/can_routes.hpp"
#include "daemon/outside/background.hpp"
#include "daemon/outside/can_sender.hpp"
#include "daemon/outside/description_texts.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca::test {

/// Thrown out of the call during which the process ends.
struct Killed {};

/// Counts the calls into the kernel. Some of them are refused, or the process ends in one of them.
class Calls {
 public:
  /// Refuses `many` calls, beginning with the `at`-th one from now (from 1).
  void refuse(std::size_t at, std::size_t many = 1);
  void kill(std::size_t at);
  void relent() { many_ = 0, kills_ = false; }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Counts a call. The result is its refusal, if it is refused.
  Result<void> make(const std::string& what);

 private:
  std::size_t count_ = 0;
  std::size_t first_ = 0;
  std::size_t many_ = 0;
  bool kills_ = false;
};

struct FakeInterface {
  int ifindex = 0;
  bool up = true;
  std::uint32_t bitrate = 0;  ///< 0: as described
  auto operator<=>(const FakeInterface&) const = default;
};

/// The contents of a gate. Its rules have the ifindex in place of the port.
struct FakeGate {
  std::map<core::GateEntry, core::GateRule> rules;
  bool closed = false;  ///< it has a program without slots, which lets nothing pass
  std::optional<gates::Mode> first_mode = {};  ///< mode in which it was attached
  void deny_all() {
    for (auto& [entry, rule] : rules) rule.pass = false;
  }
};

/// The machine, which outlives the daemons.
struct FakeKernel {
  Calls calls;
  std::map<std::string, FakeInterface> interfaces;  ///< by name
  std::map<int, FakeGate> gates;                    ///< by ifindex
  std::vector<net::CanRuleThere> can_rules;
  bool open = false;
  bool lapsed = false;
  bool pinned = true;
  std::uint64_t lapses = 0;
  std::uint64_t grace = 0;
  std::uint64_t beaten = 0;  ///< CLOCK_MONOTONIC of the latest heart-beat
  std::uint64_t until = 0;   ///< when the gates close in spite of heart-beats; 0: never
  std::uint64_t now = 0;     ///< time of advance_to()
  gates::Mode mode = gates::Mode::enforce;
  std::vector<std::string> order;  ///< log of the calls, for tests of their order
  int next_ifindex = 1;

  void plug(const std::string& name);
  void unplug(const std::string& name);
  /// Sets the time. Closes the gates as the kernel does, if no heart-beat was given within the
  /// grace.
  void advance_to(std::uint64_t to);
  [[nodiscard]] bool passes() const { return open && !lapsed && (until == 0 || now < until); }
  [[nodiscard]] const FakeInterface* interface(int ifindex) const;
};

class FakeClock final : public Clock {
 public:
  [[nodiscard]] std::uint64_t monotonic_ns() const override { return monotonic; }
  [[nodiscard]] std::uint64_t unix_ns() const override { return wall; }
  std::uint64_t monotonic = 1'000'000'000'000;
  std::uint64_t wall = 1'700'000'000'000'000'000;
};

class FakeControl final : public GateControl {
 public:
  explicit FakeControl(FakeKernel& kernel) : kernel_(kernel) {}
  void open() override;
  void close_all() override;
  [[nodiscard]] bool is_open() const override { return kernel_.open; }
  void set_mode(gates::Mode mode) override { kernel_.mode = mode; }
  [[nodiscard]] gates::Mode mode() const override { return kernel_.mode; }
  Result<void> set_grace(std::uint64_t grace) override;
  [[nodiscard]] std::uint64_t grace() const override { return kernel_.grace; }
  Result<void> set_until(std::uint64_t until) override;
  [[nodiscard]] std::uint64_t until() const override { return kernel_.until; }
  Result<void> beat(std::uint64_t now) override;
  [[nodiscard]] std::uint64_t beat_interval() const override { return 1'000'000'000; }
  [[nodiscard]] bool lapsed() const override { return kernel_.lapsed; }
  [[nodiscard]] std::uint64_t lapses() const override { return kernel_.lapses; }
  Result<void> clear_lapse(std::uint64_t now) override;
  Result<void> begin_start(std::uint64_t limit, std::uint64_t now) override;
  void beat_while_starting(std::uint64_t /*now*/) override {}
  Result<void> undo_interrupted_step() override;
  void end_start() override {}
  std::vector<std::string> take_replaced() override { return {}; }
  bool keep_epoch() override { return false; }
  Result<bool> keep_grace() override;
  Result<void> arm() override;
  Result<bool> keep_pinned() override;
  Result<void> listen(GateReports reports) override;
  [[nodiscard]] int reports_fd() const override { return -1; }
  Result<void> read_reports() override;
  /// Events of the gates, which read_reports() gives to the daemon.
  std::vector<gate_event> events;

 private:
  FakeKernel& kernel_;
  GateReports reports_;
};

class FakeLinks final : public LinkMonitor {
 public:
  explicit FakeLinks(FakeKernel& kernel) : kernel_(kernel), known_(kernel.interfaces) {}
  [[nodiscard]] int fd() const override { return -1; }
  Result<bool> refresh() override;
  [[nodiscard]] const std::string& problem() const override { return problem_; }
  [[nodiscard]] std::string name_of(int ifindex) const override;
  [[nodiscard]] bool take_tc_changed() override { return false; }
  /// The interfaces as of the latest refresh().
  [[nodiscard]] const std::map<std::string, FakeInterface>& known() const { return known_; }

 private:
  FakeKernel& kernel_;
  std::map<std::string, FakeInterface> known_;
  std::string problem_;
};

class FakeGates final : public GateDriver {
 public:
  FakeGates(FakeKernel& kernel, const FakeLinks& links) : kernel_(kernel), links_(links) {}

  Result<void> prepare(const core::System& system, std::size_t gateway) override;
  void go_back() override { goes_back_ = true, change_ = {}; }
  void end_change() override { changing_ = goes_back_ = false, change_ = {}; }
  void describe(const core::System& system, std::size_t gateway) override;
  void on_step(std::function<void()> step) override { step_ = std::move(step); }
  Result<void> follow() override;
  [[nodiscard]] bool needs_reconcile() override { return true; }
  bool repair() override { return wants_gate(); }
  void begin_repair() override {}
  bool repair(int ifindex) override;
  [[nodiscard]] bool wants_gate() const override;
  [[nodiscard]] std::optional<int> next_gate(int ifindex) const override;
  [[nodiscard]] bool out_of_hand() const override;
  [[nodiscard]] bool needs_recheck() const override { return false; }
  [[nodiscard]] const std::string& orphans_unknown() const override { return none_; }
  [[nodiscard]] std::vector<std::string> undescribed() const override { return closed_interfaces; }
  void check_bypass(int /*ifindex*/, std::int64_t /*now_s*/) override {}

  Result<void> sync(const core::GateState& wanted) override;
  Result<void> apply(const core::GateChanges& changes) override;
  void set_bands(std::size_t /*port*/, std::span<const std::uint32_t> /*limits*/) override {}
  [[nodiscard]] std::vector<gates::PlacedSlot> slots(
      std::span<const core::GateRule> rules) const override;
  using GateDriver::frames;
  [[nodiscard]] Frames frames(const core::GateState& rules,
                              const std::vector<core::GateEntry>& shared) const override;
  [[nodiscard]] std::optional<control::Watch> watch(
      const core::GateState& /*rules*/) const override {
    return watched;
  }
  [[nodiscard]] Result<void> report_again(const core::GateState& /*rules*/) const override {
    return kernel_.calls.make("report again");
  }
  [[nodiscard]] bool is_of(const gate_event& event, const core::GateState& rules) const override;
  [[nodiscard]] control::Gates gates(const core::State& /*state*/,
                                     const std::string& /*place*/) const override {
    return {};
  }
  [[nodiscard]] std::string gated_places() const override { return {}; }
  [[nodiscard]] std::size_t slot_count() const override;

  [[nodiscard]] std::size_t size() const override { return ports_.size(); }
  [[nodiscard]] const core::Port& described(std::size_t port) const override {
    return ports_[port].port;
  }
  [[nodiscard]] core::Profile profile(std::size_t port) const override {
    return ports_[port].profile;
  }
  [[nodiscard]] const std::string& network_of(std::size_t port) const override {
    return ports_[port].network;
  }
  [[nodiscard]] std::string interface_name(std::size_t port) const override {
    return ports_[port].port.identity.name;
  }
  [[nodiscard]] int gated_interface(std::size_t port) const override;
  [[nodiscard]] const std::string& problem(std::size_t port) const override {
    return ports_[port].problem;
  }
  [[nodiscard]] std::vector<core::Condition> conditions(std::size_t networks) const override;
  [[nodiscard]] std::optional<BusCounters> bus_counters(std::size_t port) override;
  [[nodiscard]] UnknownFrames unknown_frames(std::size_t port) const override;
  [[nodiscard]] std::vector<gates::UnknownFrame> seen_unknown(std::size_t port) const override;
  [[nodiscard]] std::vector<gates::RefusedSender> refused_senders(std::size_t port) const override {
    ++sender_reads;
    const auto found = senders.find(interface_name(port));
    return found == senders.end() ? std::vector<gates::RefusedSender>() : found->second;
  }
  /// The number of a subject's slot follows from the subject, as tests write it.
  [[nodiscard]] std::optional<std::uint32_t> slot_number(
      const core::GateEntry& entry) const override {
    return static_cast<std::uint32_t>(GATE_FIRST_SLOT + entry.subject);
  }
  [[nodiscard]] std::vector<Refusals> refusals(std::size_t port) const override;
  [[nodiscard]] std::vector<WithoutSlot> without_slot(std::size_t port) const override {
    const auto found = slotless.find(interface_name(port));
    return found == slotless.end() ? std::vector<WithoutSlot>() : found->second;
  }
  [[nodiscard]] std::vector<Refusals> misfits(std::size_t port) const override;
  [[nodiscard]] std::string latest_unknown(std::size_t /*port*/) const override { return "123"; }
  [[nodiscard]] std::optional<gates::Bindings> bindings(std::size_t port) const override {
    if (tables.empty() || ports_[port].profile != core::Profile::famouso) return std::nullopt;
    return gates::Bindings(*tables.at(port));
  }
  [[nodiscard]] std::vector<control::Interface> report() const override;

  std::vector<std::string> closed_interfaces;  ///< the result of undescribed()

  /// What the gate of a port must hold when all gates hold `wanted`; nullopt if it has no gate.
  [[nodiscard]] std::optional<core::GateState> share_of(std::size_t port,
                                                        const core::GateState& wanted) const;
  /// Whether the gate of a port refused a change; it denied everything from then on, perhaps until
  /// a later change.
  [[nodiscard]] bool has_refused(std::size_t port) const { return ports_[port].refused; }

  // Set by tests:
  std::map<std::string, BusCounters> carried;                        ///< by interface
  std::map<std::string, UnknownFrames> unknown;                      ///< by interface
  std::map<std::string, std::vector<gates::UnknownFrame>> seen;      ///< by interface
  std::map<std::string, std::vector<gates::RefusedSender>> senders;  ///< by interface
  mutable unsigned sender_reads = 0;                                 ///< calls of refused_senders()
  std::map<std::string, std::vector<Refusals>> refused;              ///< by interface
  std::map<std::string, std::vector<WithoutSlot>> slotless;          ///< by interface
  std::map<std::string, std::vector<Refusals>> misfitting;           ///< by interface
  std::function<void()> before_frames;                               ///< called by frames()
  std::map<core::Subject, Frames> counted;  ///< the result of frames() for the rules of a subject
  /// The result of frames() for a single rule, if there is one.
  std::map<core::Direction, std::uint64_t> passed;
  std::optional<control::Watch> watched;  ///< the result of watch()
  /// By port, for FAMOUSO; empty if there are no tags.
  std::vector<std::unique_ptr<gate_table>> tables;

 private:
  struct PortState {
    core::Port port;
    std::string network;
    core::NetworkKind kind = core::NetworkKind::can;
    core::Profile profile = core::Profile::none;
    int ifindex = 0;
    std::string problem;
    bool lost = false;
    bool refused = false;
  };
  void match(PortState& port);
  Result<void> hold(const PortState& port);
  void attach(PortState& port);
  void close_undescribed();
  [[nodiscard]] FakeGate* gate_of(std::size_t port) const;
  [[nodiscard]] std::optional<core::GateEntry> placed(const core::GateEntry& entry) const;
  Result<void> change(std::size_t port, const std::string& what,
                      const std::function<void(FakeGate&)>& make);

  FakeKernel& kernel_;
  const FakeLinks& links_;
  std::vector<PortState> ports_;
  std::set<int> commanded_;  ///< ifindexes of the gates that this daemon controls
  bool goes_back_ = false;
  bool changing_ = false;  ///< between prepare() and end_change()
  Result<void> change_;
  std::function<void()> step_ = [] {};
  std::string none_;
};

/// Begins work when it is asked to, and ends it when the test says so.
class FakeBackground final : public Background {
 public:
  bool begin(std::function<void()> work, std::function<void()> done) override;
  void forget() override { done_ = nullptr; }
  [[nodiscard]] bool waits() const override { return done_ != nullptr; }
  [[nodiscard]] std::uint64_t begun() const override { return begun_; }
  [[nodiscard]] bool busy() const override { return work_ != nullptr; }
  explicit FakeBackground(const Clock& clock) : clock_(clock) {}
  /// Does the work, and notifies the daemon that waits for it.
  void finish();
  inline static thread_local bool works = false;  ///< whether this thread is doing the work

 private:
  const Clock& clock_;
  std::function<void()> work_;
  std::function<void()> done_;
  std::uint64_t begun_ = 0;
};

/// Texts on a disk that may hang: counts accesses in the loop (the thread that makes this object)
/// outside of work in the background, because there must be none.
class FakeTexts final : public DescriptionTexts {
 public:
  Result<void> keep(const Digest& digest, const std::string& text) override {
    note();
    if (full) return fail("no space left on device");
    all.insert_or_assign(digest, text);
    damaged.erase(digest);
    return {};
  }
  [[nodiscard]] Reader reader() const override {
    return [this](const Digest& digest) -> KeptText {
      note();
      if (damaged.contains(digest)) return {.text = {}, .damage = "it is damaged"};
      const auto known = all.find(digest);
      if (known == all.end()) return {};
      return {.text = known->second, .damage = {}};
    };
  }
  void keep_only(const std::set<Digest>& digests) override {
    note();
    std::erase_if(all, [&](const auto& entry) { return !digests.contains(entry.first); });
  }
  [[nodiscard]] bool has(std::uint8_t digest) const {
    return all.contains(Digest{digest}) && !damaged.contains(Digest{digest});
  }
  std::map<Digest, std::string> all;
  std::set<Digest> damaged;
  bool full = false;
  mutable std::atomic<std::size_t> in_loop = 0;

 private:
  void note() const {
    if (std::this_thread::get_id() == loop_ && !FakeBackground::works) ++in_loop;
  }
  std::thread::id loop_ = std::this_thread::get_id();
};

class FakeCanRules final : public net::CanRules {
 public:
  explicit FakeCanRules(FakeKernel& kernel) : kernel_(kernel) {}
  [[nodiscard]] Result<std::vector<net::CanRuleThere>> read() override;
  Result<void> add(const net::CanRuleThere& rule) override;
  Result<void> remove(const net::CanRuleThere& rule) override;

 private:
  FakeKernel& kernel_;
};

/// Records the sent frames while it can send.
class FakeCan final : public CanSender {
 public:
  bool send(std::uint32_t ifindex, const can_frame& frame) override {
    problem_ = missing;
    if (ready && missing.empty()) sent.emplace_back(ifindex, frame);
    return ready;
  }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

  bool ready = true;
  std::string missing;  ///< why nothing can be sent; empty: frames can be sent
  std::vector<std::pair<std::uint32_t, can_frame>> sent;

 private:
  std::string problem_;
};

}  // namespace mlcca::test
