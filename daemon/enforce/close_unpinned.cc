// SPDX-License-Identifier: BSD-2-Clause
// Nothing is pinned here: clsact and TCX hold programs, and those their maps.
#include "daemon/enforce/close_unpinned.hpp"

#include <net/if.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <set>

#include "core/handle.hpp"
#include "daemon/enforce/attachment.hpp"
#include "daemon/enforce/control.hpp"
#include "daemon/enforce/ether_gate.hpp"
#include "daemon/enforce/ether_programs.hpp"
#include "daemon/enforce/failure.hpp"
#include "daemon/enforce/filters.hpp"
#include "daemon/enforce/programs.hpp"
#include "daemon/enforce/roster.hpp"
#include "daemon/enforce/tcx.hpp"

namespace mlcca::enforce {
namespace {

using Ids = std::set<std::uint32_t>;
using Interfaces = std::unique_ptr<struct if_nameindex, FreeWith<if_freenameindex>>;

bool has_filter(std::uint32_t ifindex) {
  return std::ranges::any_of(kBothDirections, [&](Direction direction) {
    return program_in_place(ifindex, direction).value_or(0) != 0;
  });
}

bool has_tcx(std::uint32_t ifindex, const Ids& gates) {
  return std::ranges::any_of(kBothDirections, [&](Direction direction) {
    const auto order = tcx_order(ifindex, direction);
    return order && *order && std::ranges::any_of((*order)->programs, [&](std::uint32_t program) {
             return gates.contains(program);
           });
  });
}

Result<void> put(std::uint32_t ifindex, Hook hook, const auto& programs) {
  for (const auto direction : kBothDirections) {
    const int program = programs.program_fd(direction);
    const auto done = hook == Hook::clsact ? put_filter(ifindex, direction, program)
                                           : tcx_attach_first(ifindex, direction, program);
    if (!done) return done;
    if (hook == Hook::tcx)
      static_cast<void>(remove_orphans(
          ifindex, direction,
          ids_of({programs.program_fd(Direction::ingress), programs.program_fd(Direction::egress)})
              .of(direction)));
  }
  return {};
}

Result<void> close(std::uint32_t ifindex, Hook hook, const Control& control) {
  const auto ethernet = is_ethernet(ifindex);
  if (!ethernet) return std::unexpected(ethernet.error());
  if (!*ethernet) {
    const auto programs = Programs::load({.ifindex = ifindex}, control.shared(), {});
    return programs ? put(ifindex, hook, *programs) : std::unexpected(programs.error());
  }
  const auto programs = EtherPrograms::load(
      {ifindex, false}, EtherSizes::for_slots(0, possible_cpus()), control.shared(), {});
  return programs ? put(ifindex, hook, *programs) : std::unexpected(programs.error());
}

}  // namespace

Result<std::vector<std::string>> close_unpinned() {
  const auto control = Control::create_unpinned();
  if (!control) return std::unexpected(control.error());
  const Ids gates = kernel_has_tcx() ? programs_of_gates().value_or(Ids{}) : Ids{};
  const Interfaces interfaces(::if_nameindex());
  if (!interfaces) return failure("list the interfaces", errno);
  std::vector<std::string> closed;
  for (const auto* i = interfaces.get(); i->if_index != 0; ++i) {
    const bool in_tcx = has_tcx(i->if_index, gates);
    if (!in_tcx && !has_filter(i->if_index)) continue;
    if (auto done = close(i->if_index, in_tcx ? Hook::tcx : Hook::clsact, *control); !done)
      return std::unexpected(done.error());
    closed.emplace_back(i->if_name);
  }
  return closed;
}

}  // namespace mlcca::enforce
