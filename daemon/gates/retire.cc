// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/retire.hpp"

#include <net/if.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "bpf/gate.h"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

template <class Table>
void change(const std::string& pin, auto&& change_table) {
  const Fd map = open_pin(pin);
  if (!map || !is_mappable_array(map.get(), sizeof(Table), 1)) return;
  const Mapped<Table> table(map.get(), 1);
  if (table) change_table(map_id(map.get()), table[0]);
}

/// Applies `change_table` to the table of a gate, and to the one that is to replace it.
void change_tables(const std::string& directory, auto&& change_table) {
  const std::string can = table_pin(directory);
  const std::string ether = ether_map_pin(directory, &EtherMaps::table);
  for (const std::string& pin : {can, next_of(can)}) change<gate_table>(pin, change_table);
  for (const std::string& pin : {ether, next_of(ether)}) change<ether_table>(pin, change_table);
}

}  // namespace

void retire_gate(const std::string& directory) {
  change_tables(directory,
                [](std::uint32_t, auto& table) { publish(table.retired, std::uint32_t{1}); });
}

void disown_gate(const std::string& directory, const std::vector<MapIds>& attached) {
  change_tables(directory, [&](std::uint32_t id, auto& table) {
    if (std::ranges::none_of(
            attached, [&](const MapIds& ids) { return std::ranges::find(ids, id) != ids.end(); }))
      publish(table.epoch, std::uint32_t{0});
  });
}

bool is_gone(std::uint32_t ifindex) {
  std::array<char, IF_NAMESIZE> name{};
  return if_indextoname(ifindex, name.data()) == nullptr && errno == ENXIO;
}

}  // namespace mlcca::gates
