// SPDX-License-Identifier: BSD-2-Clause
// The gate of one interface: two programs of ours in its hooks and the memory they obey.
// Closing the object leaves the gate in the kernel as it is.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/bindings.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/port_gate.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

struct GateConfig {
  std::uint32_t ifindex = 0;
  std::string name;  ///< for error texts
  core::Profile profile = core::Profile::none;
  /// The device gives every frame it has sent back through ingress (IFF_ECHO: real controllers). Do
  /// not set it for a device whose frames come from another namespace (vxcan): marks cross there.
  bool echo_by_mark = false;
  std::optional<Hook> hook;  ///< the best one that the kernel has
  /// What is dropped on its way out looks sent to the program that sent it.
  bool silent = false;
};

class Gate final : public PortGate {
 public:
  /// Puts our programs in place, by replacement where they are there already; those that an earlier
  /// daemon had in the other hook go after that. The slots and counters of what is attached now are
  /// taken over when their pins and profile fit; otherwise the gate starts without slots, so that
  /// nothing stale passes. Pins live in `control.directory()`/if<ifindex>. Acts in the calling
  /// thread's network namespace. Errors: no such interface, no privilege, a foreign filter in our
  /// place.
  static Result<Gate> attach(const GateConfig& config, const Control& control);
  /// All of attach() that takes memory: nothing is pinned or attached before put().
  static Result<Gate> load(const GateConfig& config, const Control& control);
  Result<void> put() override;
  Gate(Gate&&) noexcept;
  Gate& operator=(Gate&&) noexcept;
  ~Gate() override;

  [[nodiscard]] const GateConfig& config() const;
  [[nodiscard]] std::uint32_t ifindex() const override;
  [[nodiscard]] const std::string& name() const override;
  /// The slots of the gate that was attached before were taken over: see present().
  [[nodiscard]] bool reused() const;

  [[nodiscard]] Hook hook() const override;
  /// Both programs are in their places now and are those of this object.
  [[nodiscard]] Result<bool> attached() const override;
  /// Puts the same programs back after somebody removed or replaced them; slots and counters stay.
  Result<void> reattach() override;
  bool judge_again() override;
  [[nodiscard]] Result<std::vector<Ahead>> ahead() const override;
  Result<void> go_first() override;

  [[nodiscard]] std::vector<SlotSpec> present() const override;
  [[nodiscard]] std::size_t size() const override;
  [[nodiscard]] std::size_t room() const override { return GATE_SLOTS - GATE_FIRST_SLOT; }
  [[nodiscard]] bool is_masked(const SlotSpec& spec) const override;
  void deny_all() override;
  [[nodiscard]] Result<std::vector<std::string>> keep_pinned() const override;

  /// Frames that leave are put into bands by their identifiers: those up to the first limit
  /// (gate_arbitration()) into the first band, … at most GATE_BANDS - 1 limits, rising. No limits:
  /// they are left as they are.
  void set_bands(std::span<const std::uint32_t> limits);

  /// FAMOUSO: tags, and what their broker says of them.
  [[nodiscard]] Bindings bindings() const;

  /// Of the slot with this grant (verdict not compared); nothing where there is none.
  [[nodiscard]] std::optional<SlotCounters> counters(const SlotSpec& spec) const override;
  /// Number of the slot with this grant, as events name it.
  [[nodiscard]] std::optional<std::uint16_t> number_of(const SlotSpec& spec) const;
  [[nodiscard]] std::optional<std::uint32_t> watched_as(const SlotSpec& spec) const override;
  [[nodiscard]] Arrivals arrivals(std::uint32_t slot, std::uint64_t now) const override;
  [[nodiscard]] Result<void> tell_again(std::uint32_t slot) const override;
  [[nodiscard]] ReasonCounters reasons(Direction direction) const override;
  [[nodiscard]] ReasonCounters would_drop(Direction direction) const override;
  /// Frames without a slot, newest first.
  [[nodiscard]] std::vector<UnknownFrame> unknown() const override;

  /// Removes the pins, not the programs. Of an interface that is gone, to another network
  /// namespace, they go on with it, and let everything pass; of one that is here they stay in
  /// force.
  void unpin() override;

 private:
  [[nodiscard]] Table& table() override;
  [[nodiscard]] Result<void> arm(std::uint16_t watch) const override;

  struct State;
  explicit Gate(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Those that gates of this daemon, or of one before it, are pinned for, there or not.
[[nodiscard]] Result<std::vector<std::uint32_t>> pinned_interfaces(const Control& control);

/// Frees what is pinned for interfaces that do not exist any more in this network namespace, as the
/// kernel says of each of them.
Result<void> unpin_vanished(const Control& control);

enum class Closing : std::uint8_t {
  closed,     ///< a gate without slots is attached now
  was_gated,  ///< a gate was there already; nothing was done
};

/// For early boot and udev: puts a gate without slots on the interface unless one of ours is there.
/// Never replaces a program, so that it may race with the daemon. By clsact where no link can be
/// pinned.
Result<Closing> close_interface(const std::string& name, const std::string& root,
                                std::optional<Hook> hook = std::nullopt);

}  // namespace mlcca::enforce
