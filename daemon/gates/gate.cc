// SPDX-License-Identifier: BSD-2-Clause
// Puts the gate in place. At every moment either the old or the new program is there, and a crash
// at any line leaves pins that the next start understands: a program is pinned under its next name
// before it is attached and gets its own name after that.
#include "daemon/gates/gate.hpp"

#include <fmt/format.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gates/closed_programs.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/grace_period.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/publish.hpp"
#include "daemon/gates/retire.hpp"
#include "daemon/gates/silence_timers.hpp"

namespace mlcca::enforce {
namespace {

/// The maps of the gate that is attached to this very device, or none: an ifindex alone can have
/// been given to another device, whose gate must start empty.
Result<GateMaps> maps_in_force(const std::string& directory, const ProgramConfig& config) {
  const auto attached = maps_of_attached(directory, config.ifindex);
  if (!attached) return std::unexpected(attached.error());
  for (const MapIds& ids : *attached) {
    GateMaps maps{.table = take_map(table_pin(directory), ids),
                  .cpus = take_map(cpus_pin(directory), ids)};
    if (!maps.table || !maps.cpus || !is_mappable_array(maps.table.get(), sizeof(gate_table), 1) ||
        !is_mappable_array(maps.cpus.get(), sizeof(gate_cpu), possible_cpus()))
      continue;
    const Mapped<gate_table> table(maps.table.get(), 1);
    if (table && table[0].profile == config.profile) return maps;
  }
  disown_gate(directory, *attached);
  return GateMaps{};
}

}  // namespace

struct Gate::State {
  GateConfig config;
  Place place;
  SharedMaps shared;
  Programs programs;
  Mapped<gate_cpu> cpus;
  SlotTable slots;
  bool reused = false;
  bool was_put = false;
  std::optional<SilenceTimers> silence_timers;  ///< always, but while it is loaded

  [[nodiscard]] GatePrograms both() const {
    return {programs.program_fd(Direction::ingress), programs.program_fd(Direction::egress)};
  }
  Result<void> load_silence_timers(const Control& control);
  [[nodiscard]] Result<void> watch() const;
  [[nodiscard]] std::vector<Pin> pins() const;
  [[nodiscard]] Result<void> pin_all() const;
  Result<void> read_again();
  /// This daemon holds the gate.
  void own() const { publish(programs.table().epoch, shared.epoch); }

  static Result<std::unique_ptr<State>> load(const GateConfig& config, const Place& place,
                                             const SharedMaps& shared, const GateMaps& maps);
};

Result<std::unique_ptr<Gate::State>> Gate::State::load(const GateConfig& config, const Place& place,
                                                       const SharedMaps& shared,
                                                       const GateMaps& maps) {
  const ProgramConfig knobs{.ifindex = config.ifindex,
                            .profile = gate_profile_of(config.profile),
                            .echo_by_mark = config.echo_by_mark,
                            .silent = config.silent};
  auto programs = Programs::load(knobs, shared, maps);
  if (!programs) return std::unexpected(programs.error());
  Mapped<gate_cpu> cpus(programs->cpus_fd(), possible_cpus());
  if (!cpus) return failure("map the counters", errno);
  const bool fresh = !maps.table;
  auto slots = SlotTable::read({programs->table(), cpus.span(), programs->generation()},
                               knobs.profile, fresh, wait_for_grace_period);
  if (!slots) return std::unexpected(slots.error());
  publish(programs->table().retired, std::uint32_t{0});
  return std::make_unique<State>(State{.config = config,
                                       .place = place,
                                       .shared = shared,
                                       .programs = std::move(*programs),
                                       .cpus = std::move(cpus),
                                       .slots = std::move(*slots),
                                       .reused = !fresh,
                                       .was_put = false,
                                       .silence_timers = std::nullopt});
}

/// Programs last: what is attached is found by them.
std::vector<Pin> Gate::State::pins() const {
  const std::string& directory = place.directory;
  std::vector<Pin> all{{programs.table_fd(), table_pin(directory)},
                       {programs.cpus_fd(), cpus_pin(directory)},
                       silence_timers->pin()};
  for (const auto direction : kBothDirections)
    all.push_back({programs.program_fd(direction), program_pin(directory, direction)});
  return all;
}

Result<void> Gate::State::pin_all() const {
  if (auto made = make_pin_directory(place.directory); !made) return made;
  return pin_as_next(pins());
}

Result<void> Gate::State::read_again() {
  auto read = SlotTable::read({programs.table(), cpus.span(), programs.generation()},
                              programs.table().profile, false, wait_for_grace_period);
  if (!read) return std::unexpected(read.error());
  slots = std::move(*read);
  return {};
}

/// Timers that run already go on, by our program.
Result<void> Gate::State::load_silence_timers(const Control& control) {
  auto loaded = SilenceTimers::of_can(
      config.ifindex,
      {.table = programs.table_fd(), .control = control.map_fd(), .events = control.events_fd()},
      silence_timers_pin(place.directory), reused);
  if (!loaded) return std::unexpected(loaded.error());
  silence_timers = std::move(*loaded);
  return {};
}

Result<void> Gate::State::watch() const {
  for (const auto slot : slots.watched()) {
    if (auto armed = silence_timers->arm(slot); !armed) return armed;
    core::Progress::made();
  }
  return {};
}

Result<Gate> Gate::attach(const GateConfig& config, const Control& control) {
  auto gate = load(config, control);
  if (!gate) return gate;
  if (auto put = gate->put(); !put) return std::unexpected(put.error());
  return gate;
}

Result<Gate> Gate::load(const GateConfig& config, const Control& control) {
  const auto in_context = [&](const Error& error) {
    return fail(fmt::format("gate of {}: {}", config.name, error.text));
  };
  const Place place{config.ifindex, gate_directory(control.directory(), config.ifindex),
                    config.hook.value_or(best_hook())};
  const ProgramConfig knobs{.ifindex = config.ifindex, .profile = gate_profile_of(config.profile)};
  auto maps = maps_in_force(place.directory, knobs);
  if (!maps) return in_context(maps.error());
  auto state = State::load(config, place, control.shared(), *maps);
  // Maps that make no sense are not worth keeping: start closed.
  if (!state && maps->table) state = State::load(config, place, control.shared(), GateMaps{});
  if (!state) return in_context(state.error());

  if (auto loaded = (*state)->load_silence_timers(control); !loaded)
    return in_context(loaded.error());
  return Gate(std::move(*state));
}

Result<void> Gate::put() {
  State& state = *state_;
  Result<void> done;
  // The one that was in its place meanwhile may have changed the same table.
  if (std::exchange(state.was_put, true)) done = state.read_again();
  if (done) done = state.pin_all();
  if (done) done = state.watch();
  state.own();
  if (done) done = put_gate_in_place(state.place, state.both());
  if (done) done = name_next(state.pins());
  if (!done) return fail(fmt::format("gate of {}: {}", name(), done.error().text));
  return {};
}

Gate::Gate(std::unique_ptr<State> state) : state_(std::move(state)) {}
Gate::Gate(Gate&&) noexcept = default;
Gate& Gate::operator=(Gate&&) noexcept = default;
Gate::~Gate() = default;

const GateConfig& Gate::config() const { return state_->config; }
std::uint32_t Gate::ifindex() const { return state_->config.ifindex; }
const std::string& Gate::name() const { return state_->config.name; }
bool Gate::reused() const { return state_->reused; }

Hook Gate::hook() const { return state_->place.hook; }
Result<bool> Gate::attached() const { return are_in_place(state_->place, state_->both()); }

bool Gate::judge_again() {
  return std::atomic_ref(state_->programs.table().retired).exchange(0) != 0;
}

Result<void> Gate::reattach() {
  state_->own();
  if (auto put = put_gate_in_place(state_->place, state_->both()); !put)
    return fail(fmt::format("gate of {}: {}", name(), put.error().text));
  forget_next(state_->place.directory);
  return {};
}

Result<std::vector<Ahead>> Gate::ahead() const {
  return tcx_ahead(state_->place, ids_of(state_->both()));
}

/// A program can't be in the order of TCX twice: a copy of it takes its place.
Result<void> Gate::go_first() {
  const auto in_context = [&](const Error& error) {
    return fail(fmt::format("gate of {}: {}", name(), error.text));
  };
  const GateMaps maps{.table = Fd(::dup(state_->programs.table_fd())),
                      .cpus = Fd(::dup(state_->programs.cpus_fd()))};
  auto copy = State::load(state_->config, state_->place, state_->shared, maps);
  if (!copy) return in_context(copy.error());
  (*copy)->silence_timers = std::move(state_->silence_timers);  // they look at the same table
  auto done = (*copy)->pin_all();
  if (done) done = put_gate_first(state_->place, (*copy)->both(), state_->both());
  if (done) done = name_next((*copy)->pins());
  if (!done) {
    state_->silence_timers = std::move((*copy)->silence_timers);
    return in_context(done.error());
  }
  state_ = std::move(*copy);
  return {};
}

Bindings Gate::bindings() const { return Bindings(state_->programs.table()); }

Table& Gate::table() { return state_->slots; }
Result<void> Gate::arm(std::uint16_t watch) const { return state_->silence_timers->arm(watch); }
std::vector<SlotSpec> Gate::present() const { return state_->slots.present(); }
bool Gate::is_masked(const SlotSpec& spec) const { return state_->slots.is_masked(spec); }
std::size_t Gate::size() const { return state_->slots.size(); }
void Gate::deny_all() { state_->slots.deny_all(); }

Result<std::vector<std::string>> Gate::keep_pinned() const {
  return enforce::keep_pinned(state_->pins());
}

void Gate::set_bands(std::span<const std::uint32_t> limits) {
  gate_table& table = state_->programs.table();
  for (std::size_t i = 0; i < std::size(table.band_limit); ++i)
    std::atomic_ref(table.band_limit[i])
        .store(i < limits.size() ? limits[i] : ~0U, std::memory_order_relaxed);
  std::atomic_ref(table.bands).store(limits.empty() ? 0 : GATE_BANDS, std::memory_order_release);
}

std::optional<SlotCounters> Gate::counters(const SlotSpec& spec) const {
  const auto slot = number_of(spec);
  if (!slot) return std::nullopt;
  return slot_counters(state_->programs.table(), state_->cpus.span(), *slot);
}
std::optional<std::uint16_t> Gate::number_of(const SlotSpec& spec) const {
  return state_->slots.find(spec);
}
std::optional<std::uint32_t> Gate::watched_as(const SlotSpec& spec) const {
  const auto slot = number_of(spec);
  if (!slot || state_->programs.table().watches[*slot].period == 0) return std::nullopt;
  return slot;
}
Arrivals Gate::arrivals(std::uint32_t slot, std::uint64_t now) const {
  return enforce::arrivals(state_->programs.table().watches[slot], now);
}
Result<void> Gate::tell_again(std::uint32_t slot) const {
  return state_->programs.table().watches[slot].silent != 0 ? state_->silence_timers->arm(slot)
                                                            : Result<void>{};
}
ReasonCounters Gate::reasons(Direction direction) const {
  return reason_counters(state_->cpus.span(), direction);
}
ReasonCounters Gate::would_drop(Direction direction) const {
  return would_drop_counters(state_->programs.table(), direction);
}
std::vector<UnknownFrame> Gate::unknown() const { return unknown_frames(state_->cpus.span()); }

void Gate::unpin() {
  if (is_gone(ifindex())) publish(state_->programs.table().retired, std::uint32_t{1});
  remove_pin_directory(state_->place.directory);
}

Result<std::vector<std::uint32_t>> pinned_interfaces(const Control& control) {
  constexpr std::string_view prefix = "if";
  std::vector<std::uint32_t> found;
  const auto names = names_in(control.directory());
  if (!names && names.error() != std::errc::no_such_file_or_directory)
    return failure("read " + control.directory(), names.error().value());
  for (const std::string& name : names.value_or(std::vector<std::string>{})) {
    std::uint32_t ifindex = 0;
    const char* const end = name.data() + name.size();
    if (!name.starts_with(prefix)) continue;
    const auto number = std::from_chars(name.data() + prefix.size(), end, ifindex);
    if (number.ec == std::errc{} && number.ptr == end) found.push_back(ifindex);
  }
  return found;
}

Result<void> unpin_vanished(const Control& control) {
  const auto pinned = pinned_interfaces(control);
  if (!pinned) return std::unexpected(pinned.error());
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket) return failure("a socket to ask for interfaces", errno);
  for (const std::uint32_t ifindex : *pinned) {
    ifreq asked{};
    asked.ifr_ifindex = static_cast<int>(ifindex);
    // NOLINTNEXTLINE(*-vararg)
    if (::ioctl(socket.get(), SIOCGIFNAME, &asked) == 0 || errno != ENODEV) continue;
    const std::string directory = gate_directory(control.directory(), ifindex);
    retire_gate(directory);
    remove_pin_directory(directory);
  }
  return {};
}

namespace {

Result<bool> has_gate(Place place) {
  for (const auto hook : {Hook::tcx, Hook::clsact}) {
    place.hook = hook;
    const auto there = in_place(place);
    if (!there) return std::unexpected(there.error());
    if (there->is_gate()) return true;
  }
  return false;
}

/// Puts programs where none are. For an interface that has nothing that is worth keeping: its maps
/// are not pinned.
Result<Closing> put_closed(const Place& place, const ClosedPrograms& programs) {
  auto closing = Closing::was_gated;
  for (const auto direction : kBothDirections) {
    const auto put = put_in_empty_place(place, direction, programs.program_fd(direction));
    if (!put) return std::unexpected(put.error());
    if (*put) closing = Closing::closed;
  }
  return closing;
}

/// Of an Ethernet interface, what carries events alone. By clsact where nothing can be pinned.
Result<Closing> put_closed(Place place, const Control& control) {
  const auto ethernet = is_ethernet(place.ifindex);
  if (!ethernet) return std::unexpected(ethernet.error());
  const auto programs = *ethernet ? ClosedPrograms::of_ethernet(control.shared())
                                  : ClosedPrograms::of_can(control.shared());
  if (!programs) return std::unexpected(programs.error());
  if (place.hook == Hook::tcx && make_pin_directory(place.directory))
    if (auto put = put_closed(place, *programs)) return put;
  place.hook = Hook::clsact;
  return put_closed(place, *programs);
}

}  // namespace

Result<Closing> close_interface(const std::string& name, const std::string& root,
                                std::optional<Hook> hook) {
  const auto in_context = [&](const Error& error) {
    return fail(fmt::format("close {}: {}", name, error.text));
  };
  const std::uint32_t ifindex = if_nametoindex(name.c_str());
  if (ifindex == 0) return failure("close " + name, errno);
  const auto control = Control::create(root);
  if (!control) return in_context(control.error());
  const Place place{ifindex, gate_directory(control->directory(), ifindex),
                    hook.value_or(best_hook())};
  const auto before = has_gate(place);
  if (!before) return in_context(before.error());
  if (*before) return Closing::was_gated;

  auto closing = put_closed(place, *control);
  if (!closing) return in_context(closing.error());
  const auto after = has_gate(place);
  if (!after) return in_context(after.error());
  if (!*after)
    return fail(fmt::format(
        "close {0}: an ingress qdisc stands in the place of clsact: tc qdisc del dev {0} ingress",
        name));
  return closing;
}

}  // namespace mlcca::enforce
