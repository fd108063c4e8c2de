// SPDX-License-Identifier: BSD-2-Clause
// Tables are copied before they are read, because a daemon may change them meanwhile.
#include "daemon/gates/readback.hpp"

#include <fmt/format.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "base/number.hpp"
#include "core/model/text.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/early.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/ether_table.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/programs.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint64_t kGraceSlack = 200'000'000;  // ns: more than two ticks of the slowest kernel

/// Checks the XDP program. A driver may not support XDP, so a missing one is no problem.
void read_early(GateReading& gate, const std::string& directory) {
  const Fd pinned = open_pin(early_pin(directory));
  const std::uint32_t ours = pinned ? program_info(pinned.get()).id : 0;
  const std::string root = std::filesystem::path(directory).parent_path().parent_path().string();
  for (const std::uint32_t other : other_early_programs(gate.ifindex, ours))
    gate.problems.push_back(
        is_noted_early(root, other)
            ? fmt::format("our XDP program in the driver ({}) is not the pinned one ({})", other,
                          ours)
            : fmt::format("XDP program {} runs before ours at ingress", other));
}

void read_programs(GateReading& gate, const std::string& directory,
                   const std::vector<std::uint32_t>& maps) {
  InPlace attached;
  for (const auto hook : {Hook::tcx, Hook::clsact}) {
    gate.hook = hook;
    const auto found = in_place({gate.ifindex, directory, hook});
    if (!found) {
      gate.problems.push_back(found.error().text);
      return;
    }
    attached = *found;
    if (attached.ingress != 0 || attached.egress != 0) break;
  }
  for (const auto direction : kBothDirections) {
    const Fd pinned = open_pin(program_pin(directory, direction));
    const ProgramInfo info = pinned ? program_info(pinned.get()) : ProgramInfo{};
    const std::uint32_t there = attached.of(direction);
    if (there == 0)
      gate.problems.push_back(
          fmt::format("no program of ours is attached at {}", to_text(direction)));
    else if (there != info.id)
      gate.problems.push_back(
          fmt::format("the program attached at {} ({}) is not the pinned one ({})",
                      to_text(direction), there, info.id));
    for (const std::uint32_t map : maps)
      if (info.id != 0 && std::ranges::find(info.map_ids, map) == info.map_ids.end())
        gate.problems.push_back(fmt::format(
            "the program pinned for {} does not use the pinned map {}", to_text(direction), map));
  }
  read_early(gate, directory);
  const auto ahead = tcx_ahead({gate.ifindex, directory, gate.hook}, attached);
  if (!ahead) gate.problems.push_back(ahead.error().text);
  for (const Ahead& a : ahead.value_or(std::vector<Ahead>{}))
    gate.problems.push_back(
        fmt::format("TCX program {} runs before ours at {}", a.program, to_text(a.direction)));
}

/// Checks the two verdicts of each slot. They are equal unless the daemon is changing them just
/// now; a difference would take effect with the next change, whatever that is about.
template <class Slot>
void read_halves(GateReading& gate, std::span<const Slot> slots) {
  for (std::size_t n = GATE_FIRST_SLOT; n < slots.size(); ++n)
    if (slots[n].verdict[0] != slots[n].verdict[1])
      gate.problems.push_back(
          fmt::format("{} {:#018x}: the verdict of slot {} is another with the next generation",
                      gate.interface, slots[n].subject, n));
}

template <class Table>
void take_slots(GateReading& gate, const Result<Table>& table) {
  gate.readable = table.has_value();
  if (table)
    gate.slots = table->present();
  else
    gate.problems.push_back(table.error().text);
}

/// Checks who holds the gate. `epoch` is that of the control word.
void read_holding(GateReading& gate, const auto& table, std::uint32_t epoch) {
  if (table.retired != 0)
    gate.problems.emplace_back(
        "another program has altered it: everything passes, as if its interface had left");
  if (table.epoch < epoch) gate.problems.emplace_back("no daemon has taken it over: it is closed");
}

void read_table(GateReading& gate, const Fd& map, std::uint32_t generation, std::uint32_t epoch) {
  if (!is_mappable_array(map.get(), sizeof(gate_table), 1)) {
    gate.problems.emplace_back("the pinned table is not there or of another layout");
    return;
  }
  const Mapped<gate_table> table(map.get(), 1);
  if (!table) {
    gate.problems.push_back(failure("map the table", errno).error().text);
    return;
  }
  const auto copy = std::make_shared<gate_table>(table[0]);
  gate.profile = copy->profile;
  read_holding(gate, *copy, epoch);
  read_halves<gate_slot>(gate, copy->slots);
  const auto slots = SlotTable::read_as_found({*copy, {}, generation}, copy->profile);
  take_slots(gate, slots);
  gate.can_image = copy;
}

template <class T>
bool copy_map(const Fd& map, std::size_t count, std::vector<T>& to) {
  const Mapped<T> values(map.get(), count);
  if (!values) return false;
  to.assign(values.span().begin(), values.span().end());
  return true;
}

void read_ether_table(GateReading& gate, const EtherPinned& pinned, std::uint32_t generation,
                      std::uint32_t epoch) {
  const auto copy = std::make_shared<EtherImage>();
  copy->sizes = pinned.sizes;
  std::vector<gate_watch> watches;
  if (!copy_map(pinned.maps.table, 1, copy->table) ||
      !copy_map(pinned.maps.buckets, pinned.sizes.buckets, copy->buckets) ||
      !copy_map(pinned.maps.prefilter, pinned.sizes.prefilters(), copy->prefilters) ||
      !copy_map(pinned.maps.slots, pinned.sizes.slots, copy->slots) ||
      !copy_map(pinned.maps.contracts, pinned.sizes.contracts, copy->contracts) ||
      !copy_map(pinned.maps.watches, ETHER_WATCHES, watches)) {
    gate.problems.push_back(failure("map the table", errno).error().text);
    return;
  }
  read_holding(gate, copy->table.front(), epoch);
  read_halves<ether_slot>(gate, copy->slots);
  const auto read = EtherTable::read({.table = copy->table.data(),
                                      .buckets = copy->buckets,
                                      .prefilters = copy->prefilters,
                                      .slots = copy->slots,
                                      .contracts = copy->contracts,
                                      .counts = {},
                                      .audits = {},
                                      .watches = watches,
                                      .generation = &generation},
                                     pinned.sizes, false, 0, nullptr);
  take_slots(gate, read);
  gate.ether_image = copy;
}

GateReading read_gate(const std::string& directory, std::uint32_t ifindex, const Fd& control,
                      const gate_control& word) {
  GateReading gate;
  gate.ifindex = ifindex;
  std::array<char, IF_NAMESIZE> interface{};
  if (if_indextoname(ifindex, interface.data()) == nullptr) {
    if (errno != ENXIO) {
      gate.problems.push_back(
          failure(fmt::format("name of interface {}", ifindex), errno).error().text);
      return gate;
    }
    gate.problems.push_back(fmt::format(
        "no interface of this network namespace has the index {}: the pins are left over",
        ifindex));
    return gate;
  }
  gate.interface = interface.data();
  const auto framing = framing_of(ifindex);
  if (!framing) gate.problems.push_back(framing.error().text);
  gate.wpan = framing && *framing == Framing::wpan;
  if (!open_pin(silence_timers_pin(directory)))
    gate.problems.emplace_back("the timers that notice missing events are not pinned");
  if (const auto ether = pinned_ether_maps(directory)) {
    gate.ethernet = true;
    std::vector<std::uint32_t> ids{map_id(control.get())};
    for (const Fd EtherMaps::* const map :
         {&EtherMaps::table, &EtherMaps::buckets, &EtherMaps::slots, &EtherMaps::contracts})
      ids.push_back(map_id((ether->maps.*map).get()));
    read_programs(gate, directory, ids);
    read_ether_table(gate, *ether, word.generation, word.epoch);
    return gate;
  }
  const Fd table = open_pin(table_pin(directory));
  const Fd cpus = open_pin(cpus_pin(directory));
  if (!table || !cpus) {
    gate.problems.emplace_back("held closed: it has no maps of its own");
    return gate;
  }
  read_programs(gate, directory, {map_id(table.get()), map_id(cpus.get()), map_id(control.get())});
  read_table(gate, table, word.generation, word.epoch);
  return gate;
}

/// ns since the last heart-beat, if the daemon has given one and this exceeds the grace period by
/// twice the interval of the timer, which leaves room for a busy machine; otherwise nullopt.
std::optional<std::uint64_t> silent_too_long(const gate_control& word) {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  const auto now =
      static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(t.tv_nsec);
  if (word.grace_ns == kForEver || word.deadline == 0 ||
      now <= word.heartbeat + word.grace_ns + 2 * word.check_ns)
    return std::nullopt;
  return now - word.heartbeat;
}

std::string seconds(std::uint64_t ns) {
  return ns == kForEver ? "for ever" : fmt::format("{} s", static_cast<double>(ns) / 1e9);
}

/// Compares the grace with the one that the daemon has noted where no program can write, and the
/// deadline with both.
void compare_grace(const std::string& directory, const gate_control& word, const Fd& control,
                   std::vector<std::string>& problems) {
  const auto noted = noted_grace(directory);
  if (!noted) {
    if (word.armed != 0)
      problems.emplace_back(
          "after which time the gates close without a daemon is not noted: it can be compared with "
          "nothing");
    return;
  }
  const auto wanted = words_of_grace(*noted);
  if (!wanted) {
    problems.push_back(wanted.error().text);
  } else if (words_of_grace(word) != *wanted) {
    problems.push_back(fmt::format(
        "another program has altered after which time the gates close without a daemon: it is "
        "{} in nanoseconds, {} in ticks, checked each {}; ought to be {}, {}, {}",
        seconds(word.grace_ns), word.grace_ticks, seconds(word.check_ns), seconds(wanted->grace_ns),
        wanted->grace_ticks, seconds(wanted->check_ns)));
  }
  if (*noted == kForEver || word.open == 0 || word.lapsed != 0) return;
  const auto left = time_left(control.get());
  if (!left)
    problems.push_back(left.error().text);
  else if (*left > *noted + kGraceSlack)
    problems.push_back(
        fmt::format("another program has altered when the gates close without a daemon: in {}; "
                    "ought to be at most {}",
                    seconds(*left), seconds(*noted)));
}

/// Checks the dead-man, which closes the gates when the daemon is silent, and its timer.
std::vector<std::string> shared_problems(const std::string& directory, const gate_control& word,
                                         const Fd& control) {
  std::vector<std::string> problems;
  compare_grace(directory, word, control, problems);
  if (word.armed != 0 && !open_pin(directory + "/deadman"))
    problems.emplace_back(
        "the timer that counts the silence of a dead daemon is not pinned: it dies with it");
  if (const auto silent = silent_too_long(word); silent && word.open != 0 && word.lapsed == 0)
    problems.push_back(
        fmt::format("the daemon has been silent for {} s, longer than its grace, and the timer has "
                    "not counted it: the gates have closed by themselves",
                    *silent / 1'000'000'000));
  return problems;
}

}  // namespace

Result<Reading> read_back(const std::string& root) {
  const std::string directory = fmt::format("{}/v{}", root, GATE_LAYOUT_VERSION);
  const Fd control = open_pin(directory + "/control");
  if (!control) return failure("open " + directory + "/control", errno);
  if (!is_mappable_array(control.get(), sizeof(gate_control), 1))
    return fail(
        fmt::format("{0}/control is {1}, and not the control map of this version: mlccad puts "
                    "its own in the place when it starts",
                    directory, what_is_at(directory + "/control")));
  const Mapped<gate_control> memory(control.get(), 1);
  if (!memory) return failure("map " + directory + "/control", errno);
  const gate_control word = memory[0];
  if (word.layout_version != GATE_LAYOUT_VERSION)
    return fail(fmt::format("{}/control: layout {} instead of {}", directory, word.layout_version,
                            GATE_LAYOUT_VERSION));
  Reading reading{.open = word.open != 0,
                  .lapsed = word.lapsed != 0 || (word.open != 0 && silent_too_long(word)),
                  .audit = word.mode == GATE_AUDIT,
                  .generation = word.generation,
                  .problems = shared_problems(directory, word, control),
                  .gates = {}};
  const auto names = names_in(directory);
  if (!names) return failure("read " + directory, names.error().value());
  for (const std::string& file : *names) {
    if (!file.starts_with("if")) continue;
    if (const auto ifindex = number_in<std::uint32_t>(std::string_view(file).substr(2)))
      reading.gates.push_back(
          read_gate(gate_directory(directory, *ifindex), *ifindex, control, word));
  }
  std::ranges::sort(reading.gates, {}, &GateReading::ifindex);
  return reading;
}

}  // namespace mlcca::gates
