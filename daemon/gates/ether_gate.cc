// SPDX-License-Identifier: BSD-2-Clause
// Puts the Ethernet gate in place as gate.cc does its own: a program is pinned under its next name
// before it is attached and gets its own name after that.
#include "daemon/gates/ether_gate.hpp"

#include <fmt/format.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "daemon/gates/early.hpp"
#include "daemon/gates/ether_counters.hpp"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/grace_period.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/publish.hpp"
#include "daemon/gates/retire.hpp"
#include "daemon/gates/roster.hpp"
#include "daemon/gates/watchmen.hpp"

namespace mlcca::enforce {
namespace {

std::string next(const std::string& pin) { return pin + "_next"; }

std::optional<std::uint64_t> random_seed() {
  std::uint64_t seed = 0;
  if (getrandom(&seed, sizeof(seed), 0) != sizeof(seed)) return std::nullopt;
  return seed;
}

bool is_attached(const std::string& pin, std::uint32_t attached, int table) {
  const Fd program = open_pin(pin);
  if (!program || attached == 0) return false;
  const auto info = program_info(program.get());
  return info.id == attached &&
         std::ranges::find(info.map_ids, map_id(table)) != info.map_ids.end();
}

/// In either hook.
Result<bool> is_in_force(const std::string& directory, std::uint32_t ifindex, int table) {
  bool in_force = false;
  for (const auto hook : {Hook::tcx, Hook::clsact}) {
    const auto attached = in_place({ifindex, directory, hook});
    if (!attached) return std::unexpected(attached.error());
    for (const auto direction : kBothDirections) {
      const std::string pin = program_pin(directory, direction);
      if (is_attached(next_pin(directory, direction), attached->of(direction), table)) {
        // A crash came between attaching and renaming.
        if (auto named = rename_pin(next_pin(directory, direction), pin); !named)
          return std::unexpected(named.error());
      }
      in_force = in_force || is_attached(pin, attached->of(direction), table);
    }
  }
  return in_force;
}

/// What a gate before this one has left, if its programs are attached to this very device.
Result<EtherPinned> former_gate(const std::string& directory, std::uint32_t ifindex) {
  auto there = pinned_ether_maps(directory);
  if (!there) return EtherPinned{};
  const auto in_force = is_in_force(directory, ifindex, there->maps.front().get());
  if (!in_force) return std::unexpected(in_force.error());
  return *in_force ? std::move(*there) : EtherPinned{};
}

}  // namespace

struct EtherGate::State {
  EtherConfig config;
  Place place;
  SharedMaps shared;
  EtherSizes sizes;
  EtherPrograms programs;
  EtherMapping mapping;
  EtherTable table;
  bool reused = false;
  bool early = false;                ///< it was put in the driver
  std::optional<Watchmen> watchmen;  ///< from when it is pinned on

  static Result<std::unique_ptr<State>> load(const EtherConfig& config, const Place& place,
                                             const SharedMaps& shared, const EtherSizes& sizes,
                                             const EtherMaps& maps);
  [[nodiscard]] GatePrograms both() const {
    return {programs.program_fd(Direction::ingress), programs.program_fd(Direction::egress)};
  }
  [[nodiscard]] Result<EtherMaps> shared_maps() const;
  [[nodiscard]] Result<void> pin_all() const;
  [[nodiscard]] Result<void> name_all() const;
  Result<void> put_early_in_place();
  Result<void> watch(const Control& control);
};

Result<std::unique_ptr<EtherGate::State>> EtherGate::State::load(const EtherConfig& config,
                                                                 const Place& place,
                                                                 const SharedMaps& shared,
                                                                 const EtherSizes& sizes,
                                                                 const EtherMaps& maps) {
  const bool fresh = !maps.front();
  auto programs = EtherPrograms::load({config.ifindex, config.silent}, sizes, shared, maps);
  if (!programs) return std::unexpected(programs.error());
  auto mapping = EtherMapping::of(*programs, sizes);
  if (!mapping) return std::unexpected(mapping.error());
  const auto seed = random_seed();
  if (!seed) return failure("getrandom", errno);
  auto table = EtherTable::read(mapping->memory(), sizes, fresh, *seed, wait_for_grace_period);
  if (!table) return std::unexpected(table.error());
  publish(mapping->memory().table->retired, std::uint32_t{0});
  return std::make_unique<State>(State{.config = config,
                                       .place = place,
                                       .shared = shared,
                                       .sizes = sizes,
                                       .programs = std::move(*programs),
                                       .mapping = std::move(*mapping),
                                       .table = std::move(*table),
                                       .reused = !fresh,
                                       .early = false,
                                       .watchmen = std::nullopt});
}

Result<void> EtherGate::State::pin_all() const {
  const std::string& directory = place.directory;
  if (!reused) {
    for (std::size_t n = 0; n < kEtherMaps.size(); ++n) remove_pin(ether_map_pin(directory, n));
    remove_pin(watchmen_pin(directory));  // of a table that is not in force any more
  }
  if (auto made = make_pin_directory(directory); !made) return made;
  const auto pin_new = [](int fd, const std::string& path) -> Result<void> {
    remove_pin(path);
    const auto pinned = pin(fd, path);
    if (!pinned) return std::unexpected(pinned.error());
    return {};
  };
  for (std::size_t n = 0; !reused && n < kEtherMaps.size(); ++n)
    if (auto done = pin_new(programs.map_fd(n), ether_map_pin(directory, n)); !done) return done;
  for (const auto direction : kBothDirections)
    if (auto done = pin_new(programs.program_fd(direction), next_pin(directory, direction)); !done)
      return done;
  return pin_new(programs.early_fd(), next(early_pin(directory)));
}

/// For a second object over the same memory.
Result<EtherMaps> EtherGate::State::shared_maps() const {
  EtherMaps maps;
  for (std::size_t n = 0; n < kEtherMaps.size(); ++n) {
    maps.at(n) = Fd(::dup(programs.map_fd(n)));
    if (!maps.at(n)) return failure("share the maps of the Ethernet gate", errno);
  }
  return maps;
}

Result<void> EtherGate::State::name_all() const {
  const std::string& directory = place.directory;
  for (const auto direction : kBothDirections)
    if (auto named = rename_pin(next_pin(directory, direction), program_pin(directory, direction));
        !named)
      return named;
  return rename_pin(next(early_pin(directory)), early_pin(directory));
}

/// Of ours it takes the place, be it of a daemon before this one, or come back with its device.
/// Between looking and putting nobody is kept from putting his own there.
Result<void> EtherGate::State::put_early_in_place() {
  const std::string root =
      std::filesystem::path(place.directory).parent_path().parent_path().string();
  const std::uint32_t id = program_info(programs.early_fd()).id;
  if (auto noted = note_early(root, id); !noted) return noted;
  const std::uint32_t there = early_program(config.ifindex);
  early = there == id;
  if (early || (there != 0 && !is_noted_early(root, there) && !is_of_a_gate(there))) return {};
  early = put_early(config.ifindex, programs.early_fd(), there != 0);
  return {};
}

/// Timers that run already go on, by our program.
Result<void> EtherGate::State::watch(const Control& control) {
  auto loaded = Watchmen::of_ethernet(config.ifindex,
                                      {.table = programs.map_fd(0),
                                       .control = control.map_fd(),
                                       .events = control.events_fd(),
                                       .slots = programs.map_fd(2),
                                       .watches = programs.map_fd(8)},
                                      watchmen_pin(place.directory));
  if (!loaded) return std::unexpected(loaded.error());
  watchmen = std::move(*loaded);
  for (const std::uint16_t watch : table.watched())
    if (auto armed = watchmen->arm(watch); !armed) return armed;
  return {};
}

Result<EtherGate> EtherGate::attach(const EtherConfig& config, const Control& control) {
  const auto in_context = [&](const Error& error) {
    return fail(fmt::format("gate of {}: {}", config.name, error.text));
  };
  const auto ethernet = is_ethernet(config.ifindex);
  if (!ethernet) return in_context(ethernet.error());
  if (!*ethernet) return fail(fmt::format("gate of {}: it is no Ethernet interface", config.name));
  const Place place{config.ifindex, gate_directory(control.directory(), config.ifindex),
                    config.hook.value_or(best_hook())};
  const SharedMaps shared = control.shared();
  auto former = former_gate(place.directory, config.ifindex);
  if (!former) return in_context(former.error());
  const EtherSizes wanted = EtherSizes::for_slots(config.slots, possible_cpus());
  const bool is_there = static_cast<bool>(former->maps.front());
  const bool fits = is_there && former->sizes.slots >= wanted.slots;

  auto state = fits ? State::load(config, place, shared, former->sizes, former->maps)
                    : State::load(config, place, shared, wanted, {});
  // Maps that make no sense are not worth keeping: start closed.
  if (!state && fits) state = State::load(config, place, shared, wanted, {});
  if (!state) return in_context(state.error());
  if (is_there && !fits) {
    // Whoever was admitted goes on in the larger table.
    if (const auto old = State::load(config, place, shared, former->sizes, former->maps)) {
      SlotChanges moved;
      moved.add = (*old)->table.present();
      if (auto done = (*state)->table.apply(moved); !done) return in_context(done.error());
    }
  }
  if (auto pinned = (*state)->pin_all(); !pinned) return in_context(pinned.error());
  if (auto watched = (*state)->watch(control); !watched) return in_context(watched.error());
  if (auto put = put_gate_in_place(place, (*state)->both()); !put) return in_context(put.error());
  if (auto put = (*state)->put_early_in_place(); !put) return in_context(put.error());
  if (auto named = (*state)->name_all(); !named) return in_context(named.error());
  return EtherGate(std::move(*state));
}

EtherGate::EtherGate(std::unique_ptr<State> state) : state_(std::move(state)) {}
EtherGate::EtherGate(EtherGate&&) noexcept = default;
EtherGate& EtherGate::operator=(EtherGate&&) noexcept = default;
EtherGate::~EtherGate() = default;

bool EtherGate::holds(const EtherConfig& config) const {
  return state_->config.silent == config.silent &&
         state_->sizes.slots >= EtherSizes::for_slots(config.slots, possible_cpus()).slots;
}
bool EtherGate::reused() const { return state_->reused; }
const std::string& EtherGate::name() const { return state_->config.name; }
std::uint32_t EtherGate::ifindex() const { return state_->config.ifindex; }

std::uint32_t EtherGate::early() const { return program_info(state_->programs.early_fd()).id; }
bool EtherGate::drops_early() const { return early_program(ifindex()) == early(); }
bool EtherGate::lost_early() const { return state_->early && !drops_early(); }
Result<void> EtherGate::put_early_back() { return state_->put_early_in_place(); }

Result<bool> EtherGate::attached() const { return are_in_place(state_->place, state_->both()); }

Hook EtherGate::hook() const { return state_->place.hook; }

Result<std::vector<Ahead>> EtherGate::ahead() const {
  return tcx_ahead(state_->place, ids_of(state_->both()));
}

/// As Gate::go_first(): a copy takes the place of the programs.
Result<void> EtherGate::go_first() {
  const auto in_context = [&](const Error& error) {
    return fail(fmt::format("gate of {}: {}", name(), error.text));
  };
  const auto maps = state_->shared_maps();
  if (!maps) return in_context(maps.error());
  auto copy = State::load(state_->config, state_->place, state_->shared, state_->sizes, *maps);
  if (!copy) return in_context(copy.error());
  if (auto pinned = (*copy)->pin_all(); !pinned) return in_context(pinned.error());
  if (auto put = put_gate_first(state_->place, (*copy)->both(), state_->both()); !put)
    return in_context(put.error());
  if (auto put = (*copy)->put_early_in_place(); !put) return in_context(put.error());
  if (auto named = (*copy)->name_all(); !named) return in_context(named.error());
  (*copy)->watchmen = std::move(state_->watchmen);  // they look at the same memory
  state_ = std::move(*copy);
  return {};
}

Result<void> EtherGate::reattach() {
  if (auto put = put_gate_in_place(state_->place, state_->both()); !put)
    return fail(fmt::format("gate of {}: {}", name(), put.error().text));
  return {};
}

Table& EtherGate::table() { return state_->table; }
Result<void> EtherGate::arm(std::uint16_t watch) const { return state_->watchmen->arm(watch); }
std::vector<SlotSpec> EtherGate::present() const { return state_->table.present(); }
std::size_t EtherGate::size() const { return state_->table.size(); }
std::size_t EtherGate::room() const { return state_->sizes.slots - ETHER_FIRST_SLOT; }
void EtherGate::deny_all() { state_->table.deny_all(); }
Result<std::vector<std::string>> EtherGate::keep_pinned() const {
  const std::string& directory = state_->place.directory;
  std::vector<Pin> pins{{state_->programs.early_fd(), early_pin(directory)},
                        state_->watchmen->pin()};
  for (std::size_t n = 0; n < kEtherMaps.size(); ++n)
    pins.push_back({state_->programs.map_fd(n), ether_map_pin(directory, n)});
  for (const auto direction : kBothDirections)
    pins.push_back({state_->programs.program_fd(direction), program_pin(directory, direction)});
  return enforce::keep_pinned(pins);
}
void EtherGate::unpin() {
  if (is_gone(ifindex())) publish(state_->mapping.memory().table->retired, std::uint32_t{1});
  remove_pin_directory(state_->place.directory);
}

std::optional<SlotCounters> EtherGate::counters(const SlotSpec& spec) const {
  const auto slot = state_->table.find(spec);
  if (!slot) return std::nullopt;
  return ether_counters(state_->mapping.memory(), *slot);
}

std::optional<std::uint32_t> EtherGate::watched_as(const SlotSpec& spec) const {
  const auto slot = state_->table.find(spec);
  return slot && state_->table.watch_of(*slot) != 0 ? slot : std::nullopt;
}

Arrivals EtherGate::arrivals(std::uint32_t slot, std::uint64_t now) const {
  return enforce::arrivals(state_->mapping.memory().watches[state_->table.watch_of(slot)], now);
}

Result<void> EtherGate::tell_again(std::uint32_t slot) const {
  const std::uint16_t watch = state_->table.watch_of(slot);
  return state_->mapping.memory().watches[watch].silent != 0 ? state_->watchmen->arm(watch)
                                                             : Result<void>{};
}

std::size_t EtherGate::unwatched() const { return state_->table.unwatched(); }

ReasonCounters EtherGate::reasons(Direction direction) const {
  return ether_reasons(state_->mapping.cpus(), direction);
}

ReasonCounters EtherGate::would_drop(Direction direction) const {
  return would_drop_counters(*state_->mapping.memory().table, direction);
}

std::vector<UnknownFrame> EtherGate::unknown() const {
  return unknown_subjects(state_->mapping.cpus());
}

Result<bool> is_ethernet(std::uint32_t ifindex) {
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  if (!socket || if_indextoname(ifindex, request.ifr_name) == nullptr ||
      ::ioctl(socket.get(), SIOCGIFHWADDR, &request) != 0)
    return failure(fmt::format("ask for the hardware type of interface {}", ifindex), errno);
  return request.ifr_hwaddr.sa_family == ARPHRD_ETHER;
}

}  // namespace mlcca::enforce
