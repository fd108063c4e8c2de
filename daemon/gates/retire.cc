// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/retire.hpp"

#include <net/if.h>

#include <array>
#include <cerrno>

#include "bpf/gate.h"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::enforce {
namespace {

template <class Table>
void retire(const Fd& map) {
  if (!map || !is_mappable_array(map.get(), sizeof(Table), 1)) return;
  const Mapped<Table> table(map.get(), 1);
  if (table) publish(table[0].retired, std::uint32_t{1});
}

}  // namespace

void retire_gate(const std::string& directory) {
  retire<gate_table>(open_pin(table_pin(directory)));
  retire<ether_table>(open_pin(ether_map_pin(directory, 0)));
}

bool is_gone(std::uint32_t ifindex) {
  std::array<char, IF_NAMESIZE> name{};
  return if_indextoname(ifindex, name.data()) == nullptr && errno == ENXIO;
}

}  // namespace mlcca::enforce
