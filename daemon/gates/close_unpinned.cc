// SPDX-License-Identifier: BSD-2-Clause
// Nothing is pinned in this case: clsact and TCX hold the programs, and the programs hold their
// maps.
#include "daemon/gates/close_unpinned.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <iterator>
#include <map>
#include <memory>
#include <set>

#include "base/handle.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/filters.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/roster.hpp"
#include "daemon/gates/tcx.hpp"

namespace mlcca::gates {
namespace {

using Ids = std::set<std::uint32_t>;
using Roster = std::map<std::uint32_t, bool>;
using Interfaces = std::unique_ptr<struct if_nameindex, FreeWith<if_freenameindex>>;

/// The programs of gates at one interface: the one in our place of clsact, or those in TCX. An
/// interface that has gone meanwhile has none.
Result<Ids> programs_at(std::uint32_t ifindex, Direction direction, const Roster& gates,
                        Hook hook) {
  if (hook == Hook::clsact) {
    const auto program = program_in_place(ifindex, direction);
    if (!program) return std::unexpected(program.error());
    return *program != 0 ? Ids{*program} : Ids{};
  }
  const auto order = tcx_order(ifindex, direction);
  if (!order) return std::unexpected(order.error());
  Ids found;
  if (*order)
    std::ranges::copy_if((*order)->programs, std::inserter(found, found.end()),
                         [&](std::uint32_t program) { return gates.contains(program); });
  return found;
}

/// The programs of both directions.
Result<Ids> programs_at(std::uint32_t ifindex, const Roster& gates, Hook hook) {
  Ids found;
  for (const Direction direction : kBothDirections) {
    const auto here = programs_at(ifindex, direction, gates, hook);
    if (!here) return std::unexpected(here.error());
    found.insert(here->begin(), here->end());
  }
  return found;
}

bool is_there(std::uint32_t ifindex) {
  std::array<char, IF_NAMESIZE> name{};
  return ::if_indextoname(ifindex, name.data()) != nullptr || errno != ENXIO;
}

Result<void> put(std::uint32_t ifindex, Hook hook, const auto& programs) {
  for (const auto direction : kBothDirections) {
    const int program = programs.program_fd(direction);
    const auto done = hook == Hook::clsact ? put_filter(ifindex, direction, program)
                                           : tcx_attach_first(ifindex, direction, program);
    if (!done) return done;
    if (hook != Hook::tcx) continue;
    const auto ours =
        ids_of({programs.program_fd(Direction::ingress), programs.program_fd(Direction::egress)});
    // If our program is not known, none is removed: another program of ours drops as well.
    if (ours) static_cast<void>(remove_orphans(ifindex, direction, ours->of(direction)));
  }
  return {};
}

Result<void> close(std::uint32_t ifindex, Hook hook, const Control& control) {
  const auto framing = framing_of(ifindex);
  if (!framing) return std::unexpected(framing.error());
  if (*framing == Framing::other) {
    const auto programs = Programs::load({.ifindex = ifindex}, control.shared(), {});
    return programs ? put(ifindex, hook, *programs) : std::unexpected(programs.error());
  }
  const auto programs =
      EtherPrograms::load({.ifindex = ifindex, .wpan = *framing == Framing::wpan},
                          EtherSizes::for_slots(0, possible_cpus()), control.shared(), {});
  return programs ? put(ifindex, hook, *programs) : std::unexpected(programs.error());
}

}  // namespace

Result<std::vector<GatedInterface>> gated_interfaces() {
  const auto tcx = tcx_order(kLoopback, Direction::ingress);
  if (!tcx) return std::unexpected(tcx.error());
  const auto listed = programs_of_gates();
  // In clsact our programs are known by their place.
  if (*tcx && !listed) return std::unexpected(listed.error());
  const Roster gates = listed.value_or(Roster{});
  const auto may_pass = [&](std::uint32_t program) {
    const auto known = gates.find(program);
    return !listed || (known != gates.end() && known->second);
  };
  const Interfaces interfaces(::if_nameindex());
  if (!interfaces) return failure("list the interfaces", errno);
  std::vector<GatedInterface> found;
  for (const auto* i = interfaces.get(); i->if_index != 0; ++i)
    for (const Hook hook : {Hook::tcx, Hook::clsact}) {
      const auto programs = programs_at(i->if_index, gates, hook);
      if (!programs && !is_there(i->if_index)) break;
      if (!programs) return std::unexpected(programs.error());
      if (programs->empty()) continue;
      found.push_back({i->if_index, i->if_name, hook, std::ranges::any_of(*programs, may_pass)});
      break;
    }
  return found;
}

bool is_gated(std::uint32_t ifindex, Hook hook) {
  const Roster gates = programs_of_gates().value_or(Roster{});
  return std::ranges::all_of(kBothDirections, [&](Direction direction) {
    return !programs_at(ifindex, direction, gates, hook).value_or(Ids{}).empty();
  });
}

Result<std::vector<std::string>> close_unpinned() {
  const auto control = Control::create_unpinned();
  if (!control) return std::unexpected(control.error());
  const auto found = gated_interfaces();
  if (!found) return std::unexpected(found.error());
  std::vector<std::string> closed;
  std::string left;
  for (const GatedInterface& gated : *found) {
    const auto done = close(gated.ifindex, gated.hook, *control);
    if (done)
      closed.emplace_back(gated.name);
    else
      left += fmt::format("{}{}: {}", left.empty() ? "" : "; ", gated.name, done.error().text);
  }
  if (left.empty()) return closed;
  return fail(closed.empty() ? left
                             : fmt::format("{}; closed are {}", left, fmt::join(closed, ", ")));
}

}  // namespace mlcca::gates
