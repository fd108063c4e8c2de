// SPDX-License-Identifier: BSD-2-Clause
// The control word is memory shared with the kernel: single stores and loads. Only a heart-beat is
// a system call: it runs the program that can read the clock of the gates.
#include "daemon/gates/control.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <deadman.skel.h>
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
#include "daemon/gates/complaints.hpp"
#include "daemon/gates/events.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::enforce {
namespace {

constexpr std::uint64_t kShortestCheck = 20'000'000;    // ns
constexpr std::uint64_t kLongestCheck = 1'000'000'000;  // ns
constexpr std::uint64_t kLongestBeat = 1'000'000'000;   // ns

std::uint64_t check_interval(std::uint64_t grace) {
  return std::clamp(grace / 8, kShortestCheck, kLongestCheck);
}

/// ns between two jiffies: what the coarse clocks step by (CLOCK_MONOTONIC_COARSE).
Result<std::uint64_t> kernel_tick() {
  constexpr long shortest = 500'000;  // ns; HZ is 100 to 1000 everywhere, 24 to 1200 at the most
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

using Object = std::unique_ptr<deadman_bpf, FreeWith<deadman_bpf__destroy>>;

template <class T>
void store(T& word, T value) {
  __atomic_store_n(&word, value, __ATOMIC_RELEASE);
}

template <class T>
T load(const T& word) {
  return __atomic_load_n(&word, __ATOMIC_ACQUIRE);
}

/// See gate_ingress_token(): top bit set, not all others but the lowest.
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

}  // namespace

struct Control::State {
  std::string directory;
  Fd map;
  Mapped<gate_control> memory;
  Fd events;
  Fd deadman;     ///< the timer ends with the last reference to its map
  Object object;  ///< the programs of the dead-man, from the first beat on
  bool reused = false;

  [[nodiscard]] std::string control_pin() const { return directory + "/control"; }
  [[nodiscard]] std::string deadman_pin() const { return directory + "/deadman"; }

  Result<void> open_or_make();
  Result<void> map_word();
  Result<void> load_programs();
  [[nodiscard]] static Result<void> run(bpf_program* program, std::uint32_t mark);
  [[nodiscard]] Result<void> run_beat(gate_beat what);
};

/// Two processes may be at it: the one whose pin comes first has made it.
Result<void> Control::State::open_or_make() {
  map = open_pin(control_pin());
  reused = static_cast<bool>(map);
  if (!map) {
    auto made = make_word();
    if (!made) return std::unexpected(made.error());
    const auto pinned = pin(made->get(), control_pin());
    if (!pinned) return std::unexpected(pinned.error());
    if (*pinned) {
      map = std::move(*made);
      remove_pin(deadman_pin());  // its timer would look at another word
    } else {
      map = open_pin(control_pin());
      if (!map) return failure("open " + control_pin(), errno);
      reused = true;
    }
  }
  return map_word();
}

Result<void> Control::State::map_word() {
  if (!is_mappable_array(map.get(), sizeof(gate_control), 1))
    return fail(control_pin() + ": not the control map of this version");
  memory = Mapped<gate_control>(map.get(), 1);
  if (!memory) return failure("map " + control_pin(), errno);
  const std::uint32_t version = memory[0].layout_version;
  if (version != GATE_LAYOUT_VERSION)
    return fail(
        fmt::format("{}: layout {} instead of {}", control_pin(), version, GATE_LAYOUT_VERSION));
  return {};
}

Result<Control> Control::create(const std::string& root) {
  auto state = std::make_unique<State>();
  state->directory = fmt::format("{}/v{}", root, GATE_LAYOUT_VERSION);
  if (auto made = make_pin_directory(state->directory); !made) return std::unexpected(made.error());
  if (auto opened = state->open_or_make(); !opened) return std::unexpected(opened.error());
  auto events = open_event_ring(state->directory + "/events");
  if (!events) return std::unexpected(events.error());
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
const std::string& Control::directory() const { return state_->directory; }
int Control::map_fd() const { return state_->map.get(); }
int Control::events_fd() const { return state_->events.get(); }

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
  const __u64 kept = std::max(grace, kShortestGrace);
  const auto ticks = in_ticks(kept);
  if (!ticks) return std::unexpected(ticks.error());
  store(word().grace_ticks, static_cast<__u64>(*ticks));
  store(word().check_ns, static_cast<__u64>(check_interval(kept)));
  store(word().grace_ns, kept);
  if (load(word().deadline) != 0)
    if (auto nearer = state_->run_beat(GATE_BEAT_SHORTEN); !nearer) return nearer;
  if (load(word().armed) == 0) return {};
  return arm();
}

Result<bool> Control::keep_pinned() {
  if (!state_->deadman) return false;  // not armed yet
  const auto again =
      enforce::keep_pinned(std::array{Pin{state_->map.get(), state_->control_pin()},
                                      Pin{state_->deadman.get(), state_->deadman_pin()},
                                      Pin{state_->events.get(), state_->directory + "/events"}});
  if (!again) return std::unexpected(again.error());
  return !again->empty();
}

Result<void> Control::arm() {
  if (auto loaded = state_->load_programs(); !loaded) return loaded;
  if (auto done = pin(bpf_map__fd(state_->object->maps.deadman), state_->deadman_pin()); !done)
    return std::unexpected(done.error());
  state_->deadman = open_pin(state_->deadman_pin());
  if (!state_->deadman) return failure("open " + state_->deadman_pin(), errno);
  return State::run(state_->object->progs.gate_arm, 0);
}

/// Over the timer of a daemon before this one, if it left one.
Result<void> Control::State::load_programs() {
  if (object) return {};
  const Complaints complaints;
  Object made(deadman_bpf__open());
  if (!made) return complaints.error("open the dead-man program", errno);
  if (const int error = bpf_map__reuse_fd(made->maps.data_control, map.get()); error != 0)
    return complaints.error("dead-man: share the control map", error);
  if (const Fd pinned = open_pin(deadman_pin()); pinned)
    if (const int error = bpf_map__reuse_fd(made->maps.deadman, pinned.get()); error != 0)
      return complaints.error("dead-man: take over the timer", error);
  if (const int error = deadman_bpf__load(made.get()); error != 0)
    return complaints.error("load the dead-man program", error);
  object = std::move(made);
  return {};
}

Result<void> Control::State::run_beat(gate_beat what) {
  if (auto loaded = load_programs(); !loaded) return loaded;
  return run(object->progs.gate_beat, what);
}

Result<void> Control::State::run(bpf_program* program, std::uint32_t mark) {
  std::array<std::uint8_t, 14> frame{};  // the least that a test run takes; not looked at
  __sk_buff context{};
  context.mark = mark;
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = frame.data();
  run.data_size_in = frame.size();
  run.ctx_in = &context;
  run.ctx_size_in = sizeof(context);
  if (const int error = bpf_prog_test_run_opts(bpf_program__fd(program), &run); error != 0)
    return failure("run the dead-man program", error);
  if (run.retval != 0) return failure("start the dead-man timer", static_cast<int>(run.retval));
  return {};
}

}  // namespace mlcca::enforce
