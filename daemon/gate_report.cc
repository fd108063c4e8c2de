// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gate_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "core/control_traffic.hpp"
#include "core/words.hpp"

namespace mlcca {
namespace {

bool has_gate(const Ports& ports, std::size_t p) { return ports.profile(p) != core::Profile::none; }

std::string formats_of(std::uint8_t formats) {
  std::string words;
  const auto add = [&](unsigned format, const char* word) {
    if ((formats & format) != 0) words.append(words.empty() ? "" : " ").append(word);
  };
  add(GATE_CLASSIC, "classic");
  add(GATE_FD, "fd");
  add(GATE_XL, "xl");
  return words;
}

class Report {
 public:
  Report(const Ports& ports, const core::State& state) : ports_(ports), state_(state) {}

  [[nodiscard]] control::Gate gate_of(std::size_t p) const {
    control::Gate out;
    out.interface = ports_.interface_name(p);
    out.network = ports_.network_of(p);
    out.profile = core::words::kProfiles.of(ports_.profile(p));
    out.problem = ports_.problem(p);
    out.room = GATE_SLOTS - GATE_FIRST_SLOT;
    out.masked_room = GATE_WALK;
    const enforce::Gate* gate = ports_.gate(p);
    if (gate == nullptr) return out;
    out.attached = gate->attached().value_or(false);
    auto slots = gate->present();
    out.slots = static_cast<std::uint32_t>(slots.size());
    std::ranges::sort(slots, {}, [](const enforce::SlotSpec& s) {
      return std::tuple(s.direction, s.id, s.mask, s.source, s.uid, s.subject);
    });
    std::array<std::uint32_t, 2> masked{};
    for (const enforce::SlotSpec& slot : slots) {
      if (gate->is_masked(slot)) ++masked.at(static_cast<std::size_t>(slot.direction));
      auto& list = slot.subject == core::kControlSubject ? out.control : out.channels;
      list.push_back(slot_of(*gate, slot, ports_.profile(p)));
    }
    out.masked = std::ranges::max(masked);
    return out;
  }

 private:
  [[nodiscard]] control::GateSlot slot_of(const enforce::Gate& gate, const enforce::SlotSpec& slot,
                                          core::Profile profile) const {
    control::GateSlot out;
    out.name = name_of(slot, profile);
    out.egress = slot.direction == enforce::Direction::egress;
    out.passes = slot.pass;
    out.id = slot.id;
    out.mask = slot.mask;
    out.formats = formats_of(slot.formats);
    out.max_length = slot.max_len;
    out.source = source_of(slot);
    out.per_frame_ns = slot.per_frame;
    out.per_byte = slot.per_byte;
    out.tolerance_ns = slot.tolerance;
    out.excess_passes = slot.excess_passes;
    if (const auto counted = gate.counters(slot)) {
      out.passed = counted->passed;
      out.dropped = counted->dropped;
      out.excess = counted->excess;
      out.bytes = counted->bytes;
      if (counted->last_reason != GATE_R_PASSED)
        out.last_reason = enforce::reason_text(counted->last_reason);
    }
    return out;
  }

  [[nodiscard]] std::string name_of(const enforce::SlotSpec& slot, core::Profile profile) const {
    if (slot.subject == core::kControlSubject)
      return std::string(core::control_kind_of(profile, slot.id, slot.mask));
    const std::string subject = fmt::format("{:#x}", slot.subject);
    const auto channel = state_.find_channel(subject);
    return channel ? state_.system().channels[*channel].name : subject;
  }

  [[nodiscard]] std::string source_of(const enforce::SlotSpec& slot) const {
    if (slot.direction == enforce::Direction::ingress) return {};
    if (slot.source == GATE_NO_SOURCE) return "kernel";
    if (slot.source == 0)
      return slot.uid == GATE_ANY_UID ? "any user" : fmt::format("user {}", slot.uid);
    for (std::size_t p = 0; p < ports_.size(); ++p)
      if (const auto* gate = ports_.gate(p); gate != nullptr && gate->ifindex() == slot.source)
        return gate->name();
    return fmt::format("interface {}", slot.source);
  }

  const Ports& ports_;
  const core::State& state_;
};

}  // namespace

control::Gates gates_report(const Ports& ports, const core::State& state,
                            const std::string& place) {
  control::Gates out;
  const Report report(ports, state);
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (has_gate(ports, p) &&
        (place.empty() || place == ports.network_of(p) || place == ports.interface_name(p)))
      out.gates.push_back(report.gate_of(p));
  return out;
}

std::string gated_places(const Ports& ports) {
  std::vector<std::string> names;
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (has_gate(ports, p))
      names.push_back(fmt::format("{} of {}", ports.interface_name(p), ports.network_of(p)));
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace mlcca
