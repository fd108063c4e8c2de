// SPDX-License-Identifier: BSD-2-Clause
// A link gets its next name before its own: a crash in between leaves it in force under a name that
// the next start looks at, too.
#include "daemon/enforce/attachment.hpp"

#include <algorithm>
#include <utility>

#include "daemon/enforce/filters.hpp"
#include "daemon/enforce/pins.hpp"
#include "daemon/enforce/tcx.hpp"

namespace mlcca::enforce {

std::string link_pin(const Place& place, Direction direction) {
  return place.directory + (direction == Direction::ingress ? "/ingress_link" : "/egress_link");
}

namespace {

std::string next_link_pin(const Place& place, Direction direction) {
  return link_pin(place, direction) + "_next";
}

/// The program that a link holds on this very interface, 0: none.
std::uint32_t held_program(int link, const Place& place, Direction direction) {
  const std::uint32_t program = tcx_program(link, place.ifindex);
  const auto order = tcx_order(place.ifindex, direction);
  const bool in_order = program != 0 && order && *order &&
                        std::ranges::find((*order)->programs, program) != (*order)->programs.end();
  return in_order ? program : 0;
}

bool holds(const Fd& link, const Place& place, Direction direction) {
  return held_program(link.get(), place, direction) != 0;
}

/// The link that holds a program of ours on this very interface: of one that was moved to another
/// namespace the ifindex can be the same.
Fd live_link(const Place& place, Direction direction) {
  for (const auto& path : {link_pin(place, direction), next_link_pin(place, direction)})
    if (Fd link = open_pin(path); link && holds(link, place, direction)) return link;
  return {};
}

std::uint32_t linked_program(const Place& place, Direction direction) {
  const Fd link = live_link(place, direction);
  return link ? tcx_program(link.get(), place.ifindex) : 0;
}

/// The link gets its own name instead of the one that had it, which ends here: a name that is gone
/// would keep it for some milliseconds.
Result<void> take_name(const Place& place, Direction direction) {
  if (const Fd former = open_pin(link_pin(place, direction)); former) tcx_detach(former.get());
  return rename_pin(next_link_pin(place, direction), link_pin(place, direction));
}

Result<void> link_first(const Place& place, Direction direction, int program_fd) {
  const auto link = tcx_attach_first(place.ifindex, direction, program_fd);
  if (!link) return std::unexpected(link.error());
  remove_pin(next_link_pin(place, direction));
  if (auto pinned = pin(link->get(), next_link_pin(place, direction)); !pinned)
    return std::unexpected(pinned.error());
  return take_name(place, direction);
}

Result<void> update_link(const Place& place, Direction direction, int program_fd) {
  const Fd next = open_pin(next_link_pin(place, direction));
  if (next && holds(next, place, direction))
    if (auto named = take_name(place, direction); !named) return named;
  const Fd link = live_link(place, direction);
  return link ? tcx_update(link.get(), program_fd) : link_first(place, direction, program_fd);
}

/// Whoever pins his link first holds the place.
Result<bool> link_if_empty(const Place& place, Direction direction, int program_fd) {
  if (live_link(place, direction)) return false;
  remove_pin(link_pin(place, direction));
  const auto link = tcx_attach_first(place.ifindex, direction, program_fd);
  if (!link) return std::unexpected(link.error());
  return pin(link->get(), link_pin(place, direction));
}

}  // namespace

const char* to_text(Hook hook) { return hook == Hook::tcx ? "tcx" : "clsact"; }

Hook best_hook() { return kernel_has_tcx() ? Hook::tcx : Hook::clsact; }

Result<InPlace> in_place(const Place& place) {
  if (place.hook == Hook::tcx)
    return InPlace{.ingress = linked_program(place, Direction::ingress),
                   .egress = linked_program(place, Direction::egress)};
  const auto in = program_in_place(place.ifindex, Direction::ingress);
  if (!in) return std::unexpected(in.error());
  const auto out = program_in_place(place.ifindex, Direction::egress);
  if (!out) return std::unexpected(out.error());
  return InPlace{.ingress = *in, .egress = *out};
}

Result<void> put_in_place(const Place& place, Direction direction, int program_fd) {
  if (place.hook == Hook::clsact) {
    if (auto made = make_hooks(place.ifindex); !made) return made;
    return put_filter(place.ifindex, direction, program_fd);
  }
  return update_link(place, direction, program_fd);
}

Result<bool> put_in_empty_place(const Place& place, Direction direction, int program_fd) {
  if (place.hook == Hook::tcx) return link_if_empty(place, direction, program_fd);
  if (auto made = make_hooks(place.ifindex); !made) return std::unexpected(made.error());
  return put_filter_if_empty(place.ifindex, direction, program_fd);
}

void withdraw(const Place& place) {
  for (const auto direction : kBothDirections) {
    if (place.hook == Hook::clsact) {
      remove_filter(place.ifindex, direction);
      continue;
    }
    for (const auto& path : {link_pin(place, direction), next_link_pin(place, direction)}) {
      if (const Fd link = open_pin(path); link) tcx_detach(link.get());
      remove_pin(path);
    }
  }
}

Result<bool> are_in_place(const Place& place, const GatePrograms& programs) {
  const auto there = in_place(place);
  if (!there) return std::unexpected(there.error());
  return std::ranges::all_of(kBothDirections, [&](Direction d) {
    return there->of(d) == program_info(programs.of(d)).id;
  });
}

GateLinks links_in_place(const Place& place) {
  if (place.hook != Hook::tcx) return {};
  return {.ingress = live_link(place, Direction::ingress),
          .egress = live_link(place, Direction::egress)};
}

bool hold(const GateLinks& links, const Place& place, const GatePrograms& programs) {
  return std::ranges::all_of(kBothDirections, [&](Direction d) {
    return links.of(d) >= 0 &&
           held_program(links.of(d), place, d) == program_info(programs.of(d)).id;
  });
}

Result<void> put_gate_in_place(const Place& place, const GatePrograms& programs) {
  for (const auto direction : kBothDirections)
    if (auto put = put_in_place(place, direction, programs.of(direction)); !put) return put;
  const auto there = are_in_place(place, programs);
  if (!there) return std::unexpected(there.error());
  if (!*there)
    return fail(
        "the programs are not where they were put: remove the qdisc that stands in the place of "
        "clsact (tc qdisc show; tc qdisc del dev … ingress)");
  Place other = place;
  other.hook = place.hook == Hook::tcx ? Hook::clsact : Hook::tcx;
  withdraw(other);
  return {};
}

Result<std::vector<Ahead>> tcx_ahead(const Place& place) {
  std::vector<Ahead> ahead;
  for (const auto direction : kBothDirections) {
    const auto order = tcx_order(place.ifindex, direction);
    if (!order) return std::unexpected(order.error());
    if (!*order) continue;
    const std::uint32_t ours = place.hook == Hook::tcx ? linked_program(place, direction) : 0;
    for (const std::uint32_t program : (*order)->programs) {
      if (program == ours) break;
      ahead.push_back({.direction = direction, .hook = Hook::tcx, .program = program});
    }
  }
  return ahead;
}

Result<void> put_first(const Place& place, Direction direction, int program_fd) {
  return place.hook == Hook::tcx ? link_first(place, direction, program_fd)
                                 : put_filter_first(place.ifindex, direction, program_fd);
}

}  // namespace mlcca::enforce
