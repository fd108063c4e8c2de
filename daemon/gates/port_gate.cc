// SPDX-License-Identifier: BSD-2-Clause
// Puts a gate in place. At every moment the old or the new program is there, and a crash at any
// line leaves pins that the next start understands: a program is pinned under its next name before
// it is attached, and gets its own name afterwards.
#include "daemon/gates/port_gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gates/early.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/publish.hpp"
#include "daemon/gates/retire.hpp"

namespace mlcca::gates {
namespace {

std::unexpected<Error> of_gate(const std::string& name, const Error& error) {
  return fail(fmt::format("gate of {}: {}", name, error.text));
}

GatePrograms programs_of(const GateObject& object) {
  return {object.program_fd(Direction::ingress), object.program_fd(Direction::egress)};
}

}  // namespace

struct PortGate::State {
  Config config;
  GateLocation place;
  SharedMaps shared;
  std::unique_ptr<GateObject> object;
  SilenceTimers silence_timers;
  bool reused = false;
  bool was_put = false;
  bool early = false;  ///< our program was put in the driver

  /// Marks the gate as held by this daemon.
  void own() const { publish(object->words().epoch, shared.epoch); }
  [[nodiscard]] std::vector<Pin> pins() const;
  [[nodiscard]] Result<void> pin_all() const;
  [[nodiscard]] Result<void> watch() const;
  Result<void> put_early();
  Result<void> put();
  Result<void> go_first();
};

/// Programs come last, because what is attached is found by them.
std::vector<Pin> PortGate::State::pins() const {
  std::vector<Pin> all;
  if (object->early_fd() >= 0) all.push_back({object->early_fd(), early_pin(place.directory)});
  all.push_back(silence_timers.pin());
  for (Pin& map : object->pins(place.directory)) all.push_back(std::move(map));
  for (const auto direction : kBothDirections)
    all.push_back({object->program_fd(direction), program_pin(place.directory, direction)});
  return all;
}

Result<void> PortGate::State::pin_all() const {
  if (auto made = make_pin_directory(place.directory); !made) return made;
  return pin_as_next(pins());
}

Result<void> PortGate::State::watch() const {
  for (const std::uint16_t watch : object->table().watched()) {
    if (auto armed = silence_timers.arm(watch); !armed) return armed;
    core::Progress::made();
  }
  return {};
}

Result<void> PortGate::State::put_early() {
  if (object->early_fd() < 0) return {};
  const auto done = put_early_in_place(place, object->early_fd());
  if (!done) return std::unexpected(done.error());
  early = *done;
  return {};
}

Result<void> PortGate::State::put() {
  Result<void> done;
  // A gate that was in this place meanwhile may have changed the same table.
  if (std::exchange(was_put, true)) done = object->read_again();
  if (done) done = pin_all();
  if (done) done = watch();
  own();
  if (done) done = put_gate_in_place(place, programs_of(*object));
  if (done) done = put_early();
  if (done) done = name_next(pins());
  return done;
}

/// A program cannot be in the TCX list twice, so a copy of it takes its place.
Result<void> PortGate::State::go_first() {
  auto copy = object->copy(shared);
  if (!copy) return std::unexpected(copy.error());
  std::swap(object, *copy);
  auto done = pin_all();
  if (done) done = put_gate_first(place, programs_of(*object), programs_of(**copy));
  if (done) done = put_early();
  if (done) done = name_next(pins());
  if (!done) std::swap(object, *copy);
  return done;
}

Result<PortGate> PortGate::load(const Config& config, GateKind& kind, const Control& control) {
  const GateLocation place{config.ifindex, gate_directory(control.directory(), config.ifindex),
                           config.hook.value_or(best_hook())};
  const SharedMaps shared = control.shared();
  const auto attached = maps_of_attached(place.directory, config.ifindex);
  if (!attached) return of_gate(config.name, attached.error());
  const bool is_there = std::ranges::any_of(
      *attached, [&](const MapIds& ids) { return kind.take(place.directory, ids); });
  // The index alone does not suffice: it may have been given to another device, whose gate must
  // start empty.
  if (!is_there) disown_gate(place.directory, *attached);

  bool reused = is_there && kind.fits();
  auto object = reused ? kind.load_over_taken(shared) : kind.load_new(shared);
  // Maps that are damaged are not worth keeping: start closed.
  if (!object && std::exchange(reused, false)) object = kind.load_new(shared);
  if (!object) return of_gate(config.name, object.error());
  if (is_there && !kind.fits()) {
    // Grants stay in force in the larger table.
    if (const auto old = kind.load_over_taken(shared)) {
      SlotChanges moved;
      moved.add = (*old)->table().present();
      if (auto done = (*object)->table().apply(moved); !done)
        return of_gate(config.name, done.error());
    }
  }
  // Timers that run already continue, with our program.
  auto timers = (*object)->silence_timers(shared, silence_timers_pin(place.directory), reused);
  if (!timers) return of_gate(config.name, timers.error());
  return PortGate(std::make_unique<State>(State{.config = config,
                                                .place = place,
                                                .shared = shared,
                                                .object = std::move(*object),
                                                .silence_timers = std::move(*timers),
                                                .reused = reused}));
}

PortGate::PortGate(std::unique_ptr<State> state) : state_(std::move(state)) {}
PortGate::PortGate(PortGate&&) noexcept = default;
PortGate& PortGate::operator=(PortGate&&) noexcept = default;
PortGate::~PortGate() = default;

const std::string& PortGate::name() const { return state_->config.name; }
std::uint32_t PortGate::ifindex() const { return state_->config.ifindex; }
bool PortGate::reused() const { return state_->reused; }
bool PortGate::judges_everything() const { return object().judges_everything(); }
Hook PortGate::hook() const { return state_->place.hook; }
const GateObject& PortGate::object() const { return *state_->object; }
const VerdictTable& PortGate::table() const { return state_->object->table(); }

Result<void> PortGate::put() {
  if (auto done = state_->put(); !done) return of_gate(name(), done.error());
  return {};
}

Result<void> PortGate::go_first() {
  if (auto done = state_->go_first(); !done) return of_gate(name(), done.error());
  return {};
}

Result<bool> PortGate::attached() const {
  return are_in_place(state_->place, programs_of(object()));
}

Result<bool> PortGate::is_taken_off() const {
  return are_both_removed(state_->place, programs_of(object()));
}

Result<void> PortGate::reattach() {
  state_->own();
  if (auto put = put_gate_in_place(state_->place, programs_of(object())); !put)
    return of_gate(name(), put.error());
  forget_next(state_->place.directory);
  return {};
}

Result<std::vector<Ahead>> PortGate::ahead() const {
  const auto ours = ids_of(programs_of(object()));
  if (!ours) return std::unexpected(ours.error());
  return tcx_ahead(state_->place, *ours);
}

bool PortGate::judge_again() { return std::atomic_ref(object().words().retired).exchange(0) != 0; }

bool PortGate::hold_again() {
  if (object().words().epoch == state_->shared.epoch) return false;
  state_->own();
  return true;
}

void PortGate::unpin() {
  if (is_gone(ifindex())) publish(object().words().retired, std::uint32_t{1});
  remove_pin_directory(state_->place.directory);
}

void PortGate::give_up() {
  if (object().early_fd() >= 0) remove_early(ifindex(), object().early_fd());
  remove_pin_directory(state_->place.directory);
}

Result<std::vector<std::string>> PortGate::keep_pinned() const {
  return gates::keep_pinned(state_->pins());
}

std::uint32_t PortGate::early() const {
  return object().early_fd() < 0 ? 0 : program_info(object().early_fd()).id;
}
bool PortGate::drops_early() const {
  const std::uint32_t ours = early();
  return ours != 0 && early_program(ifindex()) == ours;
}
bool PortGate::lost_early() const { return state_->early && !drops_early(); }
Result<void> PortGate::put_early_back() { return state_->put_early(); }

Result<void> PortGate::arm_what_is_new() {
  for (const std::uint16_t watch : state_->object->table().take_newly_watched()) {
    if (auto armed = state_->silence_timers.arm(watch); !armed) return armed;
    core::Progress::made();
  }
  return {};
}

Result<void> PortGate::apply(const SlotChanges& changes) {
  if (auto applied = state_->object->table().apply(changes); !applied) return applied;
  return arm_what_is_new();
}

std::expected<void, PortGate::Refusal> PortGate::apply_together(std::span<const Change> changes) {
  std::vector<VerdictTable::Change> tables;
  tables.reserve(changes.size());
  for (const Change& c : changes) tables.push_back({&c.gate->state_->object->table(), &c.changes});
  if (auto done = VerdictTable::apply_together(tables); !done)
    return std::unexpected(
        Refusal{changes[done.error().change].gate, std::move(done.error().error)});
  for (const Change& c : changes)
    if (auto armed = c.gate->arm_what_is_new(); !armed)
      return std::unexpected(Refusal{c.gate, std::move(armed.error())});
  return {};
}

std::vector<SlotSpec> PortGate::present() const { return table().present(); }
std::size_t PortGate::size() const { return table().size(); }
std::size_t PortGate::room() const { return table().room(); }
bool PortGate::is_masked(const SlotSpec& spec) const { return table().is_masked(spec); }
void PortGate::deny_all() { state_->object->table().deny_all(); }

std::optional<std::uint32_t> PortGate::number_of(const SlotSpec& spec) const {
  return table().find(spec);
}
std::optional<SlotCounters> PortGate::counters(const SlotSpec& spec) const {
  const auto slot = number_of(spec);
  if (!slot) return std::nullopt;
  return object().counters(*slot);
}
std::optional<std::uint32_t> PortGate::watched_as(const SlotSpec& spec) const {
  const auto slot = number_of(spec);
  return slot && table().watch_of(*slot) != 0 ? slot : std::nullopt;
}
Arrivals PortGate::arrivals(std::uint32_t slot, std::uint64_t now) const {
  return gates::arrivals(object().watch(table().watch_of(slot)), now);
}
Result<void> PortGate::report_again(std::uint32_t slot) const {
  const std::uint16_t watch = table().watch_of(slot);
  return object().watch(watch).silent != 0 ? state_->silence_timers.arm(watch) : Result<void>{};
}
std::size_t PortGate::unwatched() const { return table().unwatched(); }
SlotCounters PortGate::without_slot(Direction direction) const {
  return object().counters(std::to_underlying(direction));
}
ReasonCounters PortGate::reasons(Direction direction) const { return object().reasons(direction); }
ReasonCounters PortGate::would_drop(Direction direction) const {
  return object().would_drop(direction);
}
std::vector<UnknownFrame> PortGate::unknown() const { return object().unknown(); }
std::vector<RefusedSender> PortGate::refused_senders() const { return object().refused_senders(); }

}  // namespace mlcca::gates
