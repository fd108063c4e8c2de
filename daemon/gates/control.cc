// SPDX-License-Identifier: BSD-2-Clause
// The control word is memory shared with the kernel, read and written by single loads and stores.
// Only a heart-beat is a system call: it runs the program that can read the clock of the gates.
#include "daemon/gates/control.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <deadman.skel.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/bpf.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <memory>
#include <utility>

#include "base/handle.hpp"
#include "bpf/gate.h"
#include "bpf/until.h"
#include "daemon/gates/complaints.hpp"
#include "daemon/gates/events.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/former_layouts.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/program_types.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint64_t kShortestCheck = 20'000'000;    // ns
constexpr std::uint64_t kLongestCheck = 1'000'000'000;  // ns
constexpr std::uint64_t kLongestBeat = 1'000'000'000;   // ns
constexpr int kTries = 8;

std::uint64_t check_interval(std::uint64_t grace) {
  return std::clamp(grace / 8, kShortestCheck, kLongestCheck);
}

/// ns between two jiffies, which is the resolution of the coarse clocks (CLOCK_MONOTONIC_COARSE).
Result<std::uint64_t> kernel_tick() {
  constexpr long shortest = 500'000;  // ns; HZ is usually 100 to 1000, at most 24 to 1200
  constexpr long longest = 50'000'000;
  timespec tick{};
  if (clock_getres(CLOCK_MONOTONIC_COARSE, &tick) != 0) return failure("clock_getres", errno);
  if (tick.tv_sec != 0 || tick.tv_nsec < shortest || tick.tv_nsec > longest)
    return fail(fmt::format("the kernel's clock ticks every {}.{:09} s, which cannot be",
                            tick.tv_sec, tick.tv_nsec));
  return static_cast<std::uint64_t>(tick.tv_nsec);
}

Result<std::uint64_t> in_ticks(std::uint64_t grace) {
  if (grace == kForEver) return kForEver;
  const auto tick = kernel_tick();
  if (!tick) return tick;
  return grace / *tick + (grace % *tick != 0 ? 1 : 0);
}

/// A map with one value that no program can write any more (BPF freeze).
Result<Fd> make_note(std::uint64_t grace) {
  Fd map(bpf_map_create(BPF_MAP_TYPE_ARRAY, "mlcca_grace", sizeof(std::uint32_t), sizeof(grace), 1,
                        nullptr));
  const std::uint32_t key = 0;
  if (!map || bpf_map_update_elem(map.get(), &key, &grace, BPF_ANY) != 0 ||
      bpf_map_freeze(map.get()) != 0)
    return failure("note the grace", errno);
  return map;
}

std::string grace_pin(const std::string& directory) { return directory + "/grace"; }
std::string until_pin(const std::string& directory) { return directory + "/until"; }

/// The map with the limit that an earlier daemon has set; an empty Fd if there is none.
Fd open_until(const std::string& directory) {
  Fd map = open_pin(until_pin(directory));
  return map && is_array(map.get(), sizeof(gate_until), 1) ? std::move(map) : Fd();
}

using Object = std::unique_ptr<deadman_bpf, FreeWith<deadman_bpf__destroy>>;

template <class T>
void store(T& word, T value) {
  __atomic_store_n(&word, value, __ATOMIC_RELEASE);
}

template <class T>
T load(const T& word) {
  return __atomic_load_n(&word, __ATOMIC_ACQUIRE);
}

/// A random token for gate_ingress_token(): its top bit is set, and it is neither 0xfffffffe nor
/// 0xffffffff.
Result<std::uint32_t> random_token() {
  std::uint32_t token = 0;
  do {
    if (getrandom(&token, sizeof(token), 0) != sizeof(token)) return failure("getrandom", errno);
    token |= 0x80000000U;
  } while (token >= 0xfffffffeU);
  return token;
}

Result<Fd> make_word() {
  LIBBPF_OPTS(bpf_map_create_opts, options, .map_flags = BPF_F_MMAPABLE);
  Fd map(bpf_map_create(BPF_MAP_TYPE_ARRAY, GATE_CONTROL_NAME, sizeof(std::uint32_t),
                        sizeof(gate_control), 1, &options));
  if (!map) return failure("control map", errno);
  if (map_name(map.get()) != GATE_CONTROL_NAME)
    return fail("control map: libbpf could not ask the kernel whether maps can have names");
  const auto token = random_token();
  if (!token) return std::unexpected(token.error());
  const auto ticks = in_ticks(kDefaultGrace);
  if (!ticks) return std::unexpected(ticks.error());
  gate_control word{};
  word.layout_version = GATE_LAYOUT_VERSION;
  word.grace_ns = kDefaultGrace;
  word.grace_ticks = *ticks;
  word.check_ns = check_interval(kDefaultGrace);
  word.token = *token;
  const std::uint32_t key = 0;
  if (bpf_map_update_elem(map.get(), &key, &word, BPF_ANY) != 0)
    return failure("control map", errno);
  return map;
}

/// Whether the map is a control word of this layout. A word of another layout is closed, which is
/// all that is known about it.
bool is_word_or_close(int map) {
  const std::uint32_t key = 0;
  gate_control word{};
  if (is_mappable_array(map, sizeof(word), 1) &&
      (bpf_map_lookup_elem(map, &key, &word) != 0 || word.layout_version == GATE_LAYOUT_VERSION))
    return true;
  if (is_map(map) && map_name(map) == GATE_CONTROL_NAME) close_word(map);
  return false;
}

/// Runs the program once with that mark, and returns its return value.
Result<std::uint32_t> run_once(int program, std::uint32_t mark) {
  std::array<std::uint8_t, 14> frame{};  // the smallest frame that a test run takes; not read
  __sk_buff context{};
  context.mark = mark;
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = frame.data();
  run.data_size_in = frame.size();
  run.ctx_in = &context;
  run.ctx_size_in = sizeof(context);
  if (const int error = bpf_prog_test_run_opts(program, &run); error != 0)
    return failure("run the dead-man program", error);
  return run.retval;
}

}  // namespace

struct Control::State {
  std::string directory;
  Fd map;
  Mapped<gate_control> memory;
  Fd events;
  Fd deadman;     ///< the map of the timer, which ends with the last reference to it
  Object object;  ///< the programs of the dead-man, loaded with the first heart-beat
  bool reused = false;
  std::uint32_t epoch = 0;  ///< 0: this daemon has not taken over yet
  std::vector<std::string> replaced;
  Fd grace_note;
  std::optional<GraceWords> grace;  ///< as set by this daemon
  Fd until;  ///< the limit that gate_beat reads; empty if no daemon has set one

  [[nodiscard]] std::string control_pin() const { return directory + "/control"; }
  [[nodiscard]] std::string deadman_pin() const { return directory + "/deadman"; }

  Result<void> open_or_make();
  Result<void> map_word();
  void note_replaced(const std::string& path, const std::string& was);
  Result<void> load_programs();
  Result<void> load_programs(const Fd& timer);
  [[nodiscard]] static Result<void> run(bpf_program* program, std::uint32_t mark);
  [[nodiscard]] Result<void> run_beat(gate_beat what);
  Result<void> note_grace(std::uint64_t ns);
  Result<void> note_until(std::uint64_t ns);
};

/// Two processes may do this at the same time: the one that pins first has made the word. Another
/// object with the name counts as nothing, because attached gates hold their former word, which
/// gets no heart-beat.
Result<void> Control::State::open_or_make() {
  Fd made;
  for (int i = 0; i < kTries; ++i) {
    std::string was;
    auto there = open_own(control_pin(), is_word_or_close, was);
    if (!there) return std::unexpected(there.error());
    if (!was.empty()) note_replaced(control_pin(), was);
    map = std::move(*there);
    reused = static_cast<bool>(map);
    if (map) return map_word();
    if (!made) {
      auto word = make_word();
      if (!word) return std::unexpected(word.error());
      made = std::move(*word);
    }
    const auto pinned = pin(made.get(), control_pin());
    if (!pinned) return std::unexpected(pinned.error());
    if (!*pinned) continue;
    map = std::move(made);
    remove_pin(deadman_pin());  // its timer would read another word
    return map_word();
  }
  return fail("pin " + control_pin() + ": another program pins there repeatedly");
}

Result<void> Control::State::map_word() {
  memory = Mapped<gate_control>(map.get(), 1);
  if (!memory) return failure("map " + control_pin(), errno);
  return {};
}

void Control::State::note_replaced(const std::string& path, const std::string& was) {
  replaced.push_back(fmt::format("{} was {}, and is what mlccad pins there again", path, was));
}

Result<Control> Control::create(const std::string& root) {
  auto state = std::make_unique<State>();
  state->directory = fmt::format("{}/v{}", root, GATE_LAYOUT_VERSION);
  if (auto made = make_pin_directory(state->directory); !made) return std::unexpected(made.error());
  if (auto opened = state->open_or_make(); !opened) return std::unexpected(opened.error());
  const std::string ring = state->directory + "/events";
  std::string was;
  auto events = open_event_ring(ring, was);
  if (!events) return std::unexpected(events.error());
  if (!was.empty()) state->note_replaced(ring, was);
  state->events = std::move(*events);
  return Control(std::move(state));
}

Result<Control> Control::create_unpinned() {
  auto state = std::make_unique<State>();
  auto word = make_word();
  if (!word) return std::unexpected(word.error());
  state->map = std::move(*word);
  if (auto mapped = state->map_word(); !mapped) return std::unexpected(mapped.error());
  auto events = make_event_ring();
  if (!events) return std::unexpected(events.error());
  state->events = std::move(*events);
  return Control(std::move(state));
}

Control::Control(std::unique_ptr<State> state) : state_(std::move(state)) {}
Control::Control(Control&&) noexcept = default;
Control& Control::operator=(Control&&) noexcept = default;
Control::~Control() = default;

gate_control& Control::word() const { return state_->memory[0]; }
bool Control::reused() const { return state_->reused; }
std::vector<std::string> Control::take_replaced() { return std::exchange(state_->replaced, {}); }
const std::string& Control::directory() const { return state_->directory; }
int Control::map_fd() const { return state_->map.get(); }
int Control::events_fd() const { return state_->events.get(); }

/// Gates get the next epoch before the control word has it, so that gates that stay are never
/// closed.
std::uint32_t Control::epoch() const {
  return state_->epoch != 0 ? state_->epoch : load(word().epoch) + 1U;
}
void Control::take_over() {
  state_->epoch = epoch();
  store(word().epoch, state_->epoch);
}
bool Control::keep_epoch() {
  if (state_->epoch == 0 || load(word().epoch) == state_->epoch) return false;
  store(word().epoch, state_->epoch);
  return true;
}

void Control::open() { store(word().open, std::uint32_t{1}); }
void Control::close_all() { store(word().open, std::uint32_t{0}); }
bool Control::is_open() const { return load(word().open) != 0; }

void Control::set_mode(Mode mode) {
  store(word().mode, std::uint32_t{mode == Mode::audit ? GATE_AUDIT : GATE_ENFORCE});
}
Mode Control::mode() const { return load(word().mode) == GATE_AUDIT ? Mode::audit : Mode::enforce; }

Result<void> Control::beat(std::uint64_t now) {
  store(word().heartbeat, static_cast<__u64>(now));
  return state_->run_beat(GATE_BEAT);
}
std::uint64_t Control::beat_interval() const { return std::min(grace() / 4, kLongestBeat); }

bool Control::lapsed() const { return load(word().lapsed) != 0; }
std::uint64_t Control::lapses() const { return load(word().lapses); }
Result<void> Control::clear_lapse(std::uint64_t now) {
  store(word().heartbeat, static_cast<__u64>(now));
  return state_->run_beat(GATE_BEAT_CLEAR);
}

std::uint64_t Control::grace() const { return load(word().grace_ns); }
Result<void> Control::set_grace(std::uint64_t grace) {
  const auto words = words_of_grace(std::max(grace, kShortestGrace));
  if (!words) return std::unexpected(words.error());
  auto noted = state_->note_grace(words->grace_ns);
  state_->grace = *words;
  store(word().grace_ticks, static_cast<__u64>(words->grace_ticks));
  store(word().check_ns, static_cast<__u64>(words->check_ns));
  store(word().grace_ns, static_cast<__u64>(words->grace_ns));
  if (load(word().deadline) != 0)
    if (auto nearer = state_->run_beat(GATE_BEAT_SHORTEN); !nearer) return nearer;
  if (load(word().armed) != 0)
    if (auto armed = arm(); !armed) return armed;
  return noted;
}

Result<void> Control::set_until(std::uint64_t until) {
  if (until == 0 && this->until() == 0) return {};
  if (auto noted = state_->note_until(until); !noted) return noted;
  return load(word().deadline) != 0 ? state_->run_beat(GATE_BEAT_SHORTEN) : Result<void>{};
}

std::uint64_t Control::until() const {
  const Fd there = state_->until ? Fd() : open_until(state_->directory);
  const int map = state_->until ? state_->until.get() : there.get();
  const std::uint32_t key = 0;
  gate_until value{};
  return map >= 0 && bpf_map_lookup_elem(map, &key, &value) == 0 ? value.until : 0;
}

Result<bool> Control::keep_grace() {
  if (!state_->grace || words_of_grace(word()) == *state_->grace) return false;
  if (auto set = set_grace(state_->grace->grace_ns); !set) return std::unexpected(set.error());
  return true;
}

/// Replaces the former note in one step.
Result<void> Control::State::note_grace(std::uint64_t ns) {
  if (directory.empty() || (grace_note && grace->grace_ns == ns)) return {};
  if (auto there = make_pin_directory(directory); !there) return there;
  auto made = make_note(ns);
  if (!made) return std::unexpected(made.error());
  const std::string next = grace_pin(directory) + "_next";
  if (auto pinned = pin_instead(made->get(), next); !pinned) return std::unexpected(pinned.error());
  if (auto named = rename_pin(next, grace_pin(directory)); !named) return named;
  grace_note = std::move(*made);
  return {};
}

Result<GraceWords> words_of_grace(std::uint64_t grace) {
  const auto ticks = in_ticks(grace);
  if (!ticks) return std::unexpected(ticks.error());
  return GraceWords{.grace_ns = grace, .grace_ticks = *ticks, .check_ns = check_interval(grace)};
}

GraceWords words_of_grace(const gate_control& word) {
  return {.grace_ns = load(word.grace_ns),
          .grace_ticks = load(word.grace_ticks),
          .check_ns = load(word.check_ns)};
}

std::optional<std::uint64_t> noted_grace(const std::string& directory) {
  const Fd note = open_pin(grace_pin(directory));
  const std::uint32_t key = 0;
  std::uint64_t grace = 0;
  if (!note || !is_array(note.get(), sizeof(grace), 1) ||
      bpf_map_lookup_elem(note.get(), &key, &grace) != 0)
    return std::nullopt;
  return grace;
}

Result<bool> Control::keep_pinned() {
  if (!state_->deadman) return false;  // not armed yet
  std::vector<Pin> pins{{state_->map.get(), state_->control_pin()},
                        {state_->deadman.get(), state_->deadman_pin()},
                        {state_->events.get(), state_->directory + "/events"}};
  if (state_->grace_note) pins.push_back({state_->grace_note.get(), grace_pin(state_->directory)});
  if (state_->until) pins.push_back({state_->until.get(), until_pin(state_->directory)});
  const auto again = gates::keep_pinned(pins);
  if (!again) return std::unexpected(again.error());
  return !again->empty();
}

Result<void> Control::arm() {
  if (auto loaded = state_->load_programs(); !loaded) return loaded;
  const int timer = bpf_map__fd(state_->object->maps.deadman);
  const auto was = pin_instead(timer, state_->deadman_pin());
  if (!was) return std::unexpected(was.error());
  if (!was->empty()) state_->note_replaced(state_->deadman_pin(), *was);
  state_->deadman = Fd(::fcntl(timer, F_DUPFD_CLOEXEC, 0));  // NOLINT(*-vararg)
  if (!state_->deadman) return failure("keep the timer of the dead-man", errno);
  return State::run(state_->object->progs.gate_arm, 0);
}

/// Loads with the timer of an earlier daemon, if it left one that fits.
Result<void> Control::State::load_programs() {
  if (object) return {};
  const Fd pinned = open_pin(deadman_pin());
  auto done = load_programs(pinned);
  if (!done && pinned && load_programs(Fd())) return {};
  return done;
}

Result<void> Control::State::load_programs(const Fd& timer) {
  if (auto demanded = demand_types(); !demanded) return demanded;
  const Complaints complaints;
  Object made(deadman_bpf__open());
  if (!made) return complaints.error("open the dead-man program", errno);
  if (const int error = bpf_map__reuse_fd(made->maps.data_control, map.get()); error != 0)
    return complaints.error("dead-man: share the control map", error);
  if (timer)
    if (const int error = bpf_map__reuse_fd(made->maps.deadman, timer.get()); error != 0)
      return complaints.error("dead-man: take over the timer", error);
  Fd limit = directory.empty() ? Fd() : open_until(directory);
  if (limit)
    if (const int error = bpf_map__reuse_fd(made->maps.until, limit.get()); error != 0)
      return complaints.error("dead-man: take over until when the gates may be open", error);
  if (const int error = deadman_bpf__load(made.get()); error != 0)
    return complaints.error("load the dead-man program", error);
  // These are the first programs that this process loads. Later ones rely on what libbpf has probed
  // for them.
  const int program = bpf_program__fd(made->progs.gate_beat);
  if (auto probed = probed_without_failure(made->maps.data_control, program); !probed)
    return probed;
  object = std::move(made);
  until = std::move(limit);
  return {};
}

/// The map of the limit is made with the programs, and pinned when a limit is first set.
Result<void> Control::State::note_until(std::uint64_t ns) {
  if (auto loaded = load_programs(); !loaded) return loaded;
  const auto tick = kernel_tick();
  if (!tick) return std::unexpected(tick.error());
  const int limit = bpf_map__fd(object->maps.until);
  const gate_until value{.until = ns, .tick = *tick};
  const std::uint32_t key = 0;
  if (bpf_map_update_elem(limit, &key, &value, BPF_ANY) != 0)
    return failure("set until when the gates may be open", errno);
  if (until || directory.empty()) return {};
  if (auto pinned = pin_instead(limit, until_pin(directory)); !pinned)
    return std::unexpected(pinned.error());
  until = Fd(::fcntl(limit, F_DUPFD_CLOEXEC, 0));  // NOLINT(*-vararg)
  if (!until) return failure("keep until when the gates may be open", errno);
  return {};
}

Result<void> Control::State::run_beat(gate_beat what) {
  if (auto loaded = load_programs(); !loaded) return loaded;
  return run(object->progs.gate_beat, what);
}

Result<void> Control::State::run(bpf_program* program, std::uint32_t mark) {
  const auto answer = run_once(bpf_program__fd(program), mark);
  if (!answer) return std::unexpected(answer.error());
  if (*answer != 0) return failure("start the dead-man timer", static_cast<int>(*answer));
  return {};
}

Result<std::uint64_t> time_left(int control_map) {
  const Complaints complaints;
  const Object object(deadman_bpf__open());
  if (!object) return complaints.error("open the dead-man program", errno);
  for (bpf_program* program : {object->progs.gate_arm, object->progs.gate_beat})
    bpf_program__set_autoload(program, false);
  if (const int error = bpf_map__reuse_fd(object->maps.data_control, control_map); error != 0)
    return complaints.error("dead-man: share the control map", error);
  if (const int error = deadman_bpf__load(object.get()); error != 0)
    return complaints.error("load the dead-man program", error);
  const auto ticks = run_once(bpf_program__fd(object->progs.gate_left), 0);
  if (!ticks) return std::unexpected(ticks.error());
  const auto tick = kernel_tick();
  if (!tick) return tick;
  return *ticks * *tick;
}

}  // namespace mlcca::gates
