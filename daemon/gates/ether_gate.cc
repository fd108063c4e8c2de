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
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/model/progress.hpp"
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
#include "daemon/gates/silence_timers.hpp"

namespace mlcca::enforce {
namespace {

std::optional<std::uint64_t> random_seed() {
  std::uint64_t seed = 0;
  if (getrandom(&seed, sizeof(seed), 0) != sizeof(seed)) return std::nullopt;
  return seed;
}

/// What a gate before this one has left, if its programs are attached to this very device.
Result<EtherPinned> former_gate(const std::string& directory, std::uint32_t ifindex) {
  const auto attached = maps_of_attached(directory, ifindex);
  if (!attached) return std::unexpected(attached.error());
  for (const MapIds& ids : *attached) {
    for (std::size_t n = 0; n < kEtherMaps.size(); ++n) take_map(ether_map_pin(directory, n), ids);
    auto there = pinned_ether_maps(directory);
    if (there && std::ranges::find(ids, map_id(there->maps.front().get())) != ids.end())
      return std::move(*there);
  }
  disown_gate(directory, *attached);
  return EtherPinned{};
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
  bool was_put = false;
  bool early = false;                           ///< it was put in the driver
  std::optional<SilenceTimers> silence_timers;  ///< always, but while it is loaded

  static Result<std::unique_ptr<State>> load(const EtherConfig& config, const Place& place,
                                             const SharedMaps& shared, const EtherSizes& sizes,
                                             const EtherMaps& maps);
  [[nodiscard]] GatePrograms both() const {
    return {programs.program_fd(Direction::ingress), programs.program_fd(Direction::egress)};
  }
  [[nodiscard]] Result<EtherMaps> shared_maps() const;
  [[nodiscard]] std::vector<Pin> pins() const;
  [[nodiscard]] Result<void> pin_all() const;
  Result<void> read_again();
  /// This daemon holds the gate.
  void own() const { publish(mapping.memory().table->epoch, shared.epoch); }
  Result<void> put_early_in_place();
  Result<void> load_silence_timers(const Control& control);
  [[nodiscard]] Result<void> watch() const;
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
                                       .was_put = false,
                                       .early = false,
                                       .silence_timers = std::nullopt});
}

/// Programs last: what is attached is found by them.
std::vector<Pin> EtherGate::State::pins() const {
  const std::string& directory = place.directory;
  std::vector<Pin> all{{programs.early_fd(), early_pin(directory)}, silence_timers->pin()};
  for (std::size_t n = 0; n < kEtherMaps.size(); ++n)
    all.push_back({programs.map_fd(n), ether_map_pin(directory, n)});
  for (const auto direction : kBothDirections)
    all.push_back({programs.program_fd(direction), program_pin(directory, direction)});
  return all;
}

Result<void> EtherGate::State::pin_all() const {
  if (auto made = make_pin_directory(place.directory); !made) return made;
  return pin_as_next(pins());
}

Result<void> EtherGate::State::read_again() {
  auto read = EtherTable::read(mapping.memory(), sizes, false, 0, wait_for_grace_period);
  if (!read) return std::unexpected(read.error());
  table = std::move(*read);
  return {};
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
Result<void> EtherGate::State::load_silence_timers(const Control& control) {
  auto loaded = SilenceTimers::of_ethernet(config.ifindex,
                                           {.table = programs.map_fd(0),
                                            .control = control.map_fd(),
                                            .events = control.events_fd(),
                                            .slots = programs.map_fd(2),
                                            .watches = programs.map_fd(8)},
                                           silence_timers_pin(place.directory), reused);
  if (!loaded) return std::unexpected(loaded.error());
  silence_timers = std::move(*loaded);
  return {};
}

Result<void> EtherGate::State::watch() const {
  for (const std::uint16_t watch : table.watched()) {
    if (auto armed = silence_timers->arm(watch); !armed) return armed;
    core::Progress::made();
  }
  return {};
}

Result<EtherGate> EtherGate::attach(const EtherConfig& config, const Control& control) {
  auto gate = load(config, control);
  if (!gate) return gate;
  if (auto put = gate->put(); !put) return std::unexpected(put.error());
  return gate;
}

Result<EtherGate> EtherGate::load(const EtherConfig& config, const Control& control) {
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
  if (auto loaded = (*state)->load_silence_timers(control); !loaded)
    return in_context(loaded.error());
  return EtherGate(std::move(*state));
}

Result<void> EtherGate::put() {
  State& state = *state_;
  Result<void> done;
  // As Gate::put().
  if (std::exchange(state.was_put, true)) done = state.read_again();
  if (done) done = state.pin_all();
  if (done) done = state.watch();
  state.own();
  if (done) done = put_gate_in_place(state.place, state.both());
  if (done) done = state.put_early_in_place();
  if (done) done = name_next(state.pins());
  if (!done) return fail(fmt::format("gate of {}: {}", name(), done.error().text));
  return {};
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
  (*copy)->silence_timers = std::move(state_->silence_timers);  // they look at the same memory
  auto done = (*copy)->pin_all();
  if (done) done = put_gate_first(state_->place, (*copy)->both(), state_->both());
  if (done) done = (*copy)->put_early_in_place();
  if (done) done = name_next((*copy)->pins());
  if (!done) {
    state_->silence_timers = std::move((*copy)->silence_timers);
    return in_context(done.error());
  }
  state_ = std::move(*copy);
  return {};
}

bool EtherGate::judge_again() {
  return std::atomic_ref(state_->mapping.memory().table->retired).exchange(0) != 0;
}

Result<void> EtherGate::reattach() {
  state_->own();
  if (auto put = put_gate_in_place(state_->place, state_->both()); !put)
    return fail(fmt::format("gate of {}: {}", name(), put.error().text));
  forget_next(state_->place.directory);
  return {};
}

Table& EtherGate::table() { return state_->table; }
Result<void> EtherGate::arm(std::uint16_t watch) const {
  return state_->silence_timers->arm(watch);
}
std::vector<SlotSpec> EtherGate::present() const { return state_->table.present(); }
std::size_t EtherGate::size() const { return state_->table.size(); }
std::size_t EtherGate::room() const { return state_->sizes.slots - ETHER_FIRST_SLOT; }
void EtherGate::deny_all() { state_->table.deny_all(); }
Result<std::vector<std::string>> EtherGate::keep_pinned() const {
  return enforce::keep_pinned(state_->pins());
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
  return state_->mapping.memory().watches[watch].silent != 0 ? state_->silence_timers->arm(watch)
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
