// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/ether_gate.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <cerrno>
#include <utility>

#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/grace_period.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

std::optional<std::uint64_t> random_seed() {
  std::uint64_t seed = 0;
  if (getrandom(&seed, sizeof(seed), 0) != sizeof(seed)) return std::nullopt;
  return seed;
}

class EtherObject final : public GateObject {
 public:
  static Result<std::unique_ptr<GateObject>> load(const EtherKnobs& knobs, const EtherSizes& sizes,
                                                  const SharedMaps& shared, const EtherMaps& maps);

  [[nodiscard]] int program_fd(Direction direction) const override {
    return programs_.program_fd(direction);
  }
  [[nodiscard]] int early_fd() const override { return programs_.early_fd(); }
  [[nodiscard]] std::vector<Pin> pins(const std::string& directory) const override {
    return programs_.pins(directory);
  }
  [[nodiscard]] Result<std::unique_ptr<GateObject>> copy(const SharedMaps& shared) const override {
    const auto maps = programs_.share();
    return maps ? load(knobs_, sizes_, shared, *maps) : std::unexpected(maps.error());
  }
  [[nodiscard]] Result<SilenceTimers> silence_timers(const SharedMaps& shared,
                                                     const std::string& pin_path,
                                                     bool take_over) const override {
    return SilenceTimers::of_ethernet(knobs_.ifindex,
                                      {.table = programs_.map_fd(&EtherMaps::table),
                                       .control = shared.control,
                                       .events = shared.events,
                                       .slots = programs_.map_fd(&EtherMaps::slots),
                                       .watches = programs_.map_fd(&EtherMaps::watches)},
                                      pin_path, take_over);
  }
  [[nodiscard]] VerdictTable& table() override { return table_; }
  Result<void> read_again() override {
    auto read = EtherTable::read(mapping_.memory(), sizes_, false, 0, wait_for_grace_period);
    if (!read) return std::unexpected(read.error());
    table_ = std::move(*read);
    return {};
  }
  [[nodiscard]] Words words() const override {
    ether_table& table = *mapping_.memory().table;
    return {table.retired, table.epoch};
  }
  [[nodiscard]] bool judges_everything() const override { return false; }
  [[nodiscard]] const gate_watch& watch(std::uint16_t number) const override {
    return mapping_.memory().watches[number];
  }
  [[nodiscard]] SlotCounters counters(std::uint32_t slot) const override {
    return ether_counters(mapping_.memory(), slot);
  }
  [[nodiscard]] ReasonCounters reasons(Direction direction) const override {
    return reason_counters(mapping_.cpus(), direction);
  }
  [[nodiscard]] ReasonCounters would_drop(Direction direction) const override {
    return would_drop_counters(*mapping_.memory().table, direction);
  }
  [[nodiscard]] std::vector<UnknownFrame> unknown() const override {
    return unknown_frames(mapping_.cpus());
  }
  [[nodiscard]] std::vector<RefusedSender> refused_senders() const override {
    return gates::refused_senders(mapping_.cpus());
  }

 private:
  EtherObject(const EtherKnobs& knobs, const EtherSizes& sizes, EtherPrograms programs,
              EtherMapping mapping, EtherTable table)
      : knobs_(knobs),
        sizes_(sizes),
        programs_(std::move(programs)),
        mapping_(std::move(mapping)),
        table_(std::move(table)) {}

  EtherKnobs knobs_;
  EtherSizes sizes_;
  EtherPrograms programs_;
  EtherMapping mapping_;
  EtherTable table_;
};

Result<std::unique_ptr<GateObject>> EtherObject::load(const EtherKnobs& knobs,
                                                      const EtherSizes& sizes,
                                                      const SharedMaps& shared,
                                                      const EtherMaps& maps) {
  const bool fresh = !maps.table;
  auto programs = EtherPrograms::load(knobs, sizes, shared, maps);
  if (!programs) return std::unexpected(programs.error());
  auto mapping = EtherMapping::of(*programs, sizes);
  if (!mapping) return std::unexpected(mapping.error());
  const auto seed = random_seed();
  if (!seed) return failure("getrandom", errno);
  auto table = EtherTable::read(mapping->memory(), sizes, fresh, *seed, wait_for_grace_period);
  if (!table) return std::unexpected(table.error());
  publish(mapping->memory().table->retired, std::uint32_t{0});
  return std::unique_ptr<GateObject>(
      new EtherObject(knobs, sizes, std::move(*programs), std::move(*mapping), std::move(*table)));
}

class EtherKind final : public GateKind {
 public:
  EtherKind(const EtherConfig& config, bool wpan)
      : knobs_{config.ifindex, config.silent, wpan},
        wanted_(EtherSizes::for_slots(config.slots, possible_cpus())) {}

  bool take(const std::string& directory, const MapIds& ids) override {
    auto there = take_ether_maps(directory, ids);
    if (!there) return false;
    former_ = std::move(*there);
    return true;
  }
  [[nodiscard]] bool fits() const override { return former_.sizes.slots >= wanted_.slots; }
  [[nodiscard]] Result<std::unique_ptr<GateObject>> load_over_taken(
      const SharedMaps& shared) const override {
    return EtherObject::load(knobs_, former_.sizes, shared, former_.maps);
  }
  [[nodiscard]] Result<std::unique_ptr<GateObject>> load_new(
      const SharedMaps& shared) const override {
    return EtherObject::load(knobs_, wanted_, shared, {});
  }

 private:
  EtherKnobs knobs_;
  EtherSizes wanted_;
  EtherPinned former_;
};

}  // namespace

Result<EtherGate> EtherGate::attach(const EtherConfig& config, const Control& control) {
  return put_new(load(config, control));
}

Result<EtherGate> EtherGate::load(const EtherConfig& config, const Control& control) {
  const auto framing =
      config.framing ? Result<Framing>(*config.framing) : framing_of(config.ifindex);
  if (!framing) return fail(fmt::format("gate of {}: {}", config.name, framing.error().text));
  if (*framing == Framing::other)
    return fail(fmt::format("gate of {}: it has frames neither of Ethernet nor of IEEE 802.15.4",
                            config.name));
  EtherKind kind(config, *framing == Framing::wpan);
  auto loaded = PortGate::load({config.ifindex, config.name, config.hook}, kind, control);
  if (!loaded) return std::unexpected(loaded.error());
  return EtherGate(std::move(*loaded), config.silent);
}

EtherGate::EtherGate(PortGate loaded, bool silent) : PortGate(std::move(loaded)), silent_(silent) {}

bool EtherGate::holds(const EtherConfig& config) const {
  return silent_ == config.silent &&
         room() + ETHER_FIRST_SLOT >= EtherSizes::for_slots(config.slots, possible_cpus()).slots;
}

}  // namespace mlcca::gates
