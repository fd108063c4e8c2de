// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/interrupted.hpp"

#include <cerrno>
#include <filesystem>
#include <span>
#include <string>

#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

template <class Slot>
void copy_current_half(std::span<Slot> slots, std::uint32_t generation) {
  for (Slot& slot : slots)
    publish(slot.verdict[(generation + 1) & 1], slot.verdict[generation & 1]);
}

/// Maps that do not exist or have another layout belong to no gate that will be taken over, so they
/// are skipped.
void undo_step_of_gate(const std::string& directory, std::uint32_t generation) {
  if (const auto ether = pinned_ether_maps(directory)) {
    const Mapped<ether_slot> slots(ether->maps.slots.get(), ether->sizes.slots);
    copy_current_half<ether_slot>(slots.span(), generation);
    return;
  }
  const Fd map = open_pin(table_pin(directory));
  if (!map || !is_mappable_array(map.get(), sizeof(gate_table), 1)) return;
  const Mapped<gate_table> table(map.get(), 1);
  if (table) copy_current_half<gate_slot>(table[0].slots, generation);
}

}  // namespace

Result<void> undo_interrupted_step(const Control& control) {
  const Mapped<gate_control> word(control.map_fd(), 1);
  if (!word) return failure("map the control word", errno);
  const auto names = names_in(control.directory());
  if (!names) return failure("read " + control.directory(), names.error().value());
  for (const std::string& name : *names)
    if (name.starts_with("if"))
      undo_step_of_gate((std::filesystem::path(control.directory()) / name).string(),
                        word[0].generation);
  return {};
}

}  // namespace mlcca::gates
