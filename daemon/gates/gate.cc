// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/gate.hpp"

#include <atomic>
#include <cerrno>
#include <iterator>
#include <utility>

#include "daemon/gates/failure.hpp"
#include "daemon/gates/grace_period.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

class CanObject final : public GateObject {
 public:
  static Result<std::unique_ptr<GateObject>> load(const ProgramConfig& config,
                                                  const SharedMaps& shared, const GateMaps& maps);

  [[nodiscard]] int program_fd(Direction direction) const override {
    return programs_.program_fd(direction);
  }
  [[nodiscard]] std::vector<Pin> pins(const std::string& directory) const override {
    return programs_.pins(directory);
  }
  [[nodiscard]] Result<std::unique_ptr<GateObject>> copy(const SharedMaps& shared) const override {
    const auto maps = programs_.share();
    return maps ? load(config_, shared, *maps) : std::unexpected(maps.error());
  }
  [[nodiscard]] Result<SilenceTimers> silence_timers(const SharedMaps& shared,
                                                     const std::string& pin_path,
                                                     bool take_over) const override {
    return SilenceTimers::of_can(
        config_.ifindex,
        {.table = programs_.table_fd(), .control = shared.control, .events = shared.events},
        pin_path, take_over);
  }
  [[nodiscard]] VerdictTable& table() override { return slots_; }
  Result<void> read_again() override {
    auto read = read_slots(programs_, cpus_, false, config_.profile);
    if (!read) return std::unexpected(read.error());
    slots_ = std::move(*read);
    return {};
  }
  [[nodiscard]] gate_table& memory() const { return programs_.table(); }
  [[nodiscard]] Words words() const override { return {memory().retired, memory().epoch}; }
  [[nodiscard]] bool judges_everything() const override { return true; }
  [[nodiscard]] const gate_watch& watch(std::uint16_t number) const override {
    return memory().watches[number];
  }
  [[nodiscard]] SlotCounters counters(std::uint32_t slot) const override {
    return slot_counters(memory(), cpus_.span(), slot);
  }
  [[nodiscard]] ReasonCounters reasons(Direction direction) const override {
    return reason_counters(cpus_.span(), direction);
  }
  [[nodiscard]] ReasonCounters would_drop(Direction direction) const override {
    return would_drop_counters(memory(), direction);
  }
  [[nodiscard]] std::vector<UnknownFrame> unknown() const override {
    return unknown_frames(cpus_.span());
  }
  [[nodiscard]] std::vector<RefusedSender> refused_senders() const override {
    return gates::refused_senders(cpus_.span());
  }

 private:
  CanObject(const ProgramConfig& config, Programs programs, Mapped<gate_cpu> cpus, SlotTable slots)
      : config_(config),
        programs_(std::move(programs)),
        cpus_(std::move(cpus)),
        slots_(std::move(slots)) {}
  static Result<SlotTable> read_slots(const Programs& programs, const Mapped<gate_cpu>& cpus,
                                      bool fresh, std::uint32_t profile);

  ProgramConfig config_;
  Programs programs_;
  Mapped<gate_cpu> cpus_;
  SlotTable slots_;
};

Result<SlotTable> CanObject::read_slots(const Programs& programs, const Mapped<gate_cpu>& cpus,
                                        bool fresh, std::uint32_t profile) {
  return SlotTable::read({programs.table(), cpus.span(), programs.generation()}, profile, fresh,
                         wait_for_grace_period);
}

Result<std::unique_ptr<GateObject>> CanObject::load(const ProgramConfig& config,
                                                    const SharedMaps& shared,
                                                    const GateMaps& maps) {
  auto programs = Programs::load(config, shared, maps);
  if (!programs) return std::unexpected(programs.error());
  Mapped<gate_cpu> cpus(programs->cpus_fd(), possible_cpus());
  if (!cpus) return failure("map the counters", errno);
  auto slots = read_slots(*programs, cpus, !maps.table, config.profile);
  if (!slots) return std::unexpected(slots.error());
  publish(programs->table().retired, std::uint32_t{0});
  return std::unique_ptr<GateObject>(
      new CanObject(config, std::move(*programs), std::move(cpus), std::move(*slots)));
}

class CanKind final : public GateKind {
 public:
  explicit CanKind(const GateConfig& config)
      : config_{.ifindex = config.ifindex,
                .profile = gate_profile_of(config.profile),
                .echo_by_mark = config.echo_by_mark,
                .silent = config.silent} {}

  /// Slots of another profile concern other frames, so maps of another profile are not taken.
  bool take(const std::string& directory, const MapIds& ids) override {
    auto maps = take_gate_maps(directory, ids);
    if (!maps) return false;
    const Mapped<gate_table> table(maps->table.get(), 1);
    if (!table || table[0].profile != config_.profile) return false;
    maps_ = std::move(*maps);
    return true;
  }
  [[nodiscard]] Result<std::unique_ptr<GateObject>> load_over_taken(
      const SharedMaps& shared) const override {
    return CanObject::load(config_, shared, maps_);
  }
  [[nodiscard]] Result<std::unique_ptr<GateObject>> load_new(
      const SharedMaps& shared) const override {
    return CanObject::load(config_, shared, {});
  }

 private:
  ProgramConfig config_;
  GateMaps maps_;
};

}  // namespace

Result<Gate> Gate::attach(const GateConfig& config, const Control& control) {
  return put_new(load(config, control));
}

Result<Gate> Gate::load(const GateConfig& config, const Control& control) {
  CanKind kind(config);
  auto loaded = PortGate::load({config.ifindex, config.name, config.hook}, kind, control);
  if (!loaded) return std::unexpected(loaded.error());
  return Gate(std::move(*loaded), config);
}

Gate::Gate(PortGate loaded, GateConfig config)
    : PortGate(std::move(loaded)), config_(std::move(config)) {}

/// The object was made by load(), so it is a CanObject.
gate_table& Gate::memory() const { return static_cast<const CanObject&>(object()).memory(); }

Bindings Gate::bindings() const { return Bindings(memory()); }

void Gate::set_bands(std::span<const std::uint32_t> limits) {
  gate_table& table = memory();
  for (std::size_t i = 0; i < std::size(table.band_limit); ++i)
    std::atomic_ref(table.band_limit[i])
        .store(i < limits.size() ? limits[i] : ~0U, std::memory_order_relaxed);
  std::atomic_ref(table.bands).store(limits.empty() ? 0 : GATE_BANDS, std::memory_order_release);
}

}  // namespace mlcca::gates
