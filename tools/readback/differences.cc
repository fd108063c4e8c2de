// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/differences.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "bpf/ether.h"
#include "core/model/station.hpp"
#include "core/model/text.hpp"
#include "daemon/store/records.hpp"

namespace mlcca::readback {
namespace {

using gates::Direction;
using gates::GateReading;
using gates::SlotSpec;
using Words = std::vector<std::string>;

std::string formats_of(const SlotSpec& s, bool ethernet) {
  const auto named = [&s](int bit, const char* name) { return (s.formats & bit) != 0 ? name : ""; };
  return ethernet ? fmt::format("{}{}", named(ETHER_UNFRAGMENTED, " unfragmented"),
                                named(ETHER_FRAGMENT, " fragments"))
                  : fmt::format("{}{}{}{}", named(GATE_CLASSIC, " classic"), named(GATE_FD, " FD"),
                                named(GATE_XL, " XL"), named(GATE_TRANSPORT, " transport"));
}

std::string source_of(const SlotSpec& s, const NameOf& name_of) {
  if (s.source == 0) return "a local program";
  return s.source == GATE_NO_SOURCE ? "the kernel" : name_of(s.source);
}

/// The content of a slot as words, in a fixed order.
Words words_of(const SlotSpec& s, bool ethernet, const NameOf& name_of) {
  return {fmt::format("verdict {}", s.pass ? "pass" : "deny"),
          fmt::format("identifier {:#x}", s.id),
          fmt::format("mask {:#x}", s.mask),
          fmt::format("source {}", source_of(s, name_of)),
          s.uid == GATE_ANY_UID ? "any user" : fmt::format("user {}", s.uid),
          s.origin == 0 ? "no origin" : fmt::format("origin {:#x}", s.origin),
          s.station == 0 ? "any station" : "station " + core::to_text(core::Station{s.station}),
          fmt::format("length {}", s.max_len),
          fmt::format("formats{}", formats_of(s, ethernet)),
          fmt::format("{} ns a frame", s.per_frame),
          fmt::format("{}/256 ns a byte", s.per_byte),
          fmt::format("tolerance {} ns", s.tolerance),
          fmt::format("excess {}", s.excess_passes ? "passes" : "dropped"),
          fmt::format("period {} ns", s.period),
          fmt::format("timeout {} ns", s.silence),
          fmt::format("together {} ns", s.together)};
}

std::size_t unlike(const Words& a, const Words& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i] ? 1 : 0;
  return count;
}

/// The words of `a` that `b` does not have.
std::string but_for(const Words& a, const Words& b) {
  Words own;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i]) own.push_back(a[i]);
  return fmt::format("{}", fmt::join(own, ", "));
}

/// The slots of a subject in one direction that differ between kernel and journal.
struct Odd {
  std::vector<Words> is;
  std::vector<Words> ought;
};

/// Appends lines about the differences. Each present slot is compared with the most similar
/// expected one.
void append_lines(Odd& odd, const std::string& where, std::vector<std::string>& to) {
  for (const Words& is : odd.is) {
    const auto like = std::ranges::min_element(
        odd.ought, {}, [&is](const Words& ought) { return unlike(is, ought); });
    if (like == odd.ought.end()) {
      to.push_back(fmt::format("{}: is {}; ought not to be there", where, fmt::join(is, ", ")));
      continue;
    }
    to.push_back(
        fmt::format("{}: is {}; ought to be {}", where, but_for(is, *like), but_for(*like, is)));
    odd.ought.erase(like);
  }
  for (const Words& ought : odd.ought)
    to.push_back(fmt::format("{}: is not there; ought to be {}", where, fmt::join(ought, ", ")));
}

/// Whether an Ethernet gate has all its watches in use, so that further slots are not supervised
/// (which the gate reports).
bool watches_all_it_can(const GateReading& gate) {
  return gate.ethernet && std::ranges::count_if(gate.slots, [](const SlotSpec& s) {
                            return s.period != 0;
                          }) >= ETHER_WATCHES - 1;
}

}  // namespace

std::vector<std::string> differences(const GateReading& gate, std::span<const SlotSpec> ought,
                                     const NameOf& name_of) {
  // As in the gate, publishers with the same grant share a slot, which passes frames of either.
  std::map<SlotSpec, SlotSpec, gates::ByGrant> wanted;
  for (const SlotSpec& s : ought) {
    SlotSpec& shared = wanted.try_emplace(s, s).first->second;
    shared.pass = shared.pass || s.pass;
  }
  const bool may_lack_watch = watches_all_it_can(gate);
  std::map<std::pair<std::uint64_t, Direction>, Odd> odd;
  for (const SlotSpec& is : gate.slots) {
    const auto same = wanted.find(is);
    if (same != wanted.end()) {
      SlotSpec& other = same->second;
      if (is.period == 0 && may_lack_watch) other.period = other.silence = other.together = 0;
      if (is == other) {
        wanted.erase(same);
        continue;
      }
    }
    odd[{is.subject, is.direction}].is.push_back(words_of(is, gate.ethernet, name_of));
  }
  for (const auto& [grant, s] : wanted)
    odd[{s.subject, s.direction}].ought.push_back(words_of(s, gate.ethernet, name_of));
  std::vector<std::string> lines;
  for (auto& [of, slots] : odd)
    append_lines(
        slots,
        fmt::format("{} {} {}", gate.interface, to_text(of.second), core::format_subject(of.first)),
        lines);
  return lines;
}

void compare_slots(gates::Reading& reading, const store::Contents& journal) {
  std::map<std::uint32_t, std::vector<SlotSpec>> ought;
  for (const auto& [subject, record] : journal.enforced) {
    const auto slots = store::slots_in(record, subject);
    if (!slots)
      reading.problems.push_back("what the journal says of the slots of subject " +
                                 core::format_subject(subject) + " is not understood");
    for (const auto& placed : slots.value_or(std::vector<gates::PlacedSlot>{}))
      ought[placed.ifindex].push_back(placed.slot);
  }
  const NameOf name_of = [&](std::uint32_t ifindex) {
    const auto gate = std::ranges::find(reading.gates, ifindex, &GateReading::ifindex);
    return gate != reading.gates.end() && !gate->interface.empty()
               ? gate->interface
               : fmt::format("interface {}", ifindex);
  };
  for (GateReading& gate : reading.gates) {
    // Of an interface that is no longer a port only the passing slots matter.
    if (!gate.readable || std::ranges::none_of(journal.gated, [&gate](const auto& known) {
          return known.second.ifindex == gate.ifindex;
        }))
      continue;
    if (journal.enforced.empty() && !gate.slots.empty()) {
      gate.problems.emplace_back(
          "its slots cannot be compared: the journal is of an mlccad that did not write them down, "
          "restart it");
      continue;
    }
    for (std::string& line : differences(gate, ought[gate.ifindex], name_of))
      gate.problems.push_back(std::move(line));
  }
}

}  // namespace mlcca::readback
