// SPDX-License-Identifier: BSD-2-Clause
// Text about the contents of gates: control traffic, then channels, with limits and counters.
#include <fmt/format.h>

#include <algorithm>

#include "base/many.hpp"
#include "tools/render.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

/// The policing of a slot: "50/s, 256 at once", "250 kB/s"; empty if it is not policed.
std::string limit(const control::GateSlot& slot) {
  constexpr double second = 1e9;
  constexpr double unit = 256;  // per_byte counts ns/256
  const char* const excess = slot.excess_passes ? ", more is reported" : "";
  if (slot.per_frame_ns != 0) {
    const double rate = second / static_cast<double>(slot.per_frame_ns);
    const std::uint64_t burst = slot.tolerance_ns / slot.per_frame_ns;
    const auto text = rate < 0.1 ? fmt::format("1 in {:.0f} s", 1 / rate)
                                 : fmt::format("{:.{}f}/s", rate, rate < 10 ? 1 : 0);
    return fmt::format("{}, {} at once{}", text, burst + 1, excess);
  }
  if (slot.per_byte != 0)
    return bytes_per_second(
               static_cast<std::uint64_t>(second * unit / static_cast<double>(slot.per_byte))) +
           excess;
  return {};
}

Cell verdict(const control::GateSlot& slot, bool control) {
  if (slot.passes) return {"passes", Style::good};
  return control ? Cell{"off", Style::dim} : Cell{"refused", Style::bad};
}

Cell number(std::uint64_t n, Style style = Style::plain) {
  return {n == 0 ? "" : fmt::format("{}", n), style};
}

/// The excess frames that were dropped. Those that audit mode passed are in another column.
Cell excess(const control::GateSlot& slot) {
  return number(slot.excess - std::min(slot.excess, slot.would_exceed), Style::warning);
}

/// The identifier of a slot; empty on Ethernet, where slots are found by subject.
Cell identifier(const control::GateSlot& slot, bool ethernet) {
  return {ethernet ? "" : print_can_id(slot.id)};
}

Cell mask(const control::GateSlot& slot, bool ethernet) {
  if (ethernet) return {};
  // The gate compares all 29 bits of an 11-bit identifier; only the 11 are shown.
  const unsigned digits = slot.id >> 31 != 0 ? 8 : 3;
  const std::uint32_t bits = digits == 8 ? 0x1fffffff : 0x7ff;
  return {fmt::format("{:0{}x}", slot.mask & bits, digits)};
}

std::string slots(const std::vector<control::GateSlot>& all, bool control, bool ethernet,
                  Color color) {
  const char* const other = ethernet ? "OTHER TRAFFIC" : "CONTROL TRAFFIC";
  TextTable table({{control ? other : "CHANNEL"},
                   {"DIRECTION"},
                   {"SOURCE"},
                   {"IDENTIFIER"},
                   {"MASK"},
                   {"FORMATS"},
                   {"MAX LENGTH", Align::right},
                   {"VERDICT"},
                   {"LIMIT"},
                   {"PASSED", Align::right},
                   {"DROPPED", Align::right},
                   {"WOULD DROP", Align::right},
                   {"EXCESS", Align::right},
                   {"LAST REASON"}});
  for (const auto& slot : all)
    table.add({{slot.name, Style::bold},
               {slot.egress ? "out" : "in"},
               {slot.source},
               identifier(slot, ethernet),
               mask(slot, ethernet),
               {slot.formats},
               ethernet && control ? Cell{} : Cell{fmt::format("{}", slot.max_length)},
               verdict(slot, control),
               {limit(slot)},
               number(slot.passed),
               number(slot.dropped, Style::warning),
               slot.would_drop == 0 ? Cell{} : number(slot.would_drop, Style::warning),
               excess(slot),
               {slot.last_reason, Style::warning}});
  return table.empty() ? "" : table.text(color, "  ");
}

std::string attachment(const control::Gate& gate, const control::Interface* interface,
                       Color color) {
  if (!gate.attached) return styled("NOT ATTACHED", Style::bad, color);
  if (gate.profile == "none") return styled("closed: no profile", Style::bad, color);
  std::string text = styled("attached", Style::good, color);
  if (interface == nullptr) return text;
  if (!interface->hook.empty()) text += " by " + printable(interface->hook);
  if (interface->drops_early) text += ", early in the driver";
  return text;
}

std::string reasons(const control::Interface& interface, Color color) {
  TextTable table({{"REASON"}, {"DIRECTION"}, {"FRAMES", Align::right}});
  for (const auto* traffic : {&interface.ingress, &interface.egress})
    for (const auto& count : traffic->reasons)
      table.add({{count.reason},
                 {traffic == &interface.egress ? "out" : "in"},
                 {fmt::format("{}", count.frames)}});
  return table.empty() ? "" : table.text(color, "  ");
}

}  // namespace

const control::Interface* interface_of(const control::Gate& gate,
                                       const std::vector<control::Interface>& interfaces) {
  const auto found = std::ranges::find_if(interfaces, [&](const control::Interface& i) {
    return i.name == gate.interface && i.network == gate.network;
  });
  return found == interfaces.end() ? nullptr : &*found;
}

std::string render(const control::Gates& gates, const std::vector<control::Interface>& interfaces,
                   Color color) {
  std::string text;
  for (const auto& gate : gates.gates) {
    const bool ethernet = gate.masked_slots_limit == 0;
    const control::Interface* const interface = interface_of(gate, interfaces);
    if (!text.empty()) text += '\n';
    text += fmt::format("{} on {}: profile {}, {}, {} of {}",
                        styled(gate.interface, Style::bold, color), printable(gate.network),
                        printable(gate.profile), attachment(gate, interface, color), gate.slots,
                        many(gate.slots_limit, "slot"));
    if (gate.masked_slots != 0)
      text += fmt::format(", {} of {}", gate.masked_slots, many(gate.masked_slots_limit, "mask"));
    text += '\n';
    if (!gate.problem.empty()) text += "  " + styled(gate.problem, Style::bad, color) + '\n';
    text +=
        slots(gate.control, true, ethernet, color) + slots(gate.channels, false, ethernet, color);
    if (ethernet && gate.slots > gate.channels.size())
      text += fmt::format("  and {} more\n", many(gate.slots - gate.channels.size(), "slot"));
    if (interface != nullptr) text += reasons(*interface, color);
  }
  return text.empty() ? "this gateway has no gates\n" : text;
}

}  // namespace mlcca::tools
