// SPDX-License-Identifier: BSD-2-Clause
// In TCX a program of ours is recognised by its pin: its own name, or the next name, which it has
// before it is attached. A crash in between leaves it in force under the next name, which the next
// start checks.
#include "daemon/gates/attachment.hpp"

#include <bpf/bpf.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "base/handle.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/filters.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/roster.hpp"
#include "daemon/gates/tcx.hpp"

namespace mlcca::gates {
namespace {

constexpr int kTries = 8;  ///< attempts, while another program changes the order at the same time

struct Named {
  Fd fd;
  std::uint32_t id = 0;
};

/// Our programs in the TCX list that a pin names, except `without`.
Result<std::vector<Named>> named_programs(const GateLocation& place, Direction direction,
                                          std::uint32_t without = 0) {
  std::vector<Named> named;
  const auto order = tcx_order(place.ifindex, direction);
  if (!order) return std::unexpected(order.error());
  if (!*order || (*order)->programs.empty()) return named;
  for (const auto& path :
       {program_pin(place.directory, direction), next_pin(place.directory, direction)}) {
    Fd fd = open_pin(path);
    const std::uint32_t id = fd && is_program(fd.get()) ? program_info(fd.get()).id : 0;
    if (id != without && (*order)->has(id)) named.push_back({std::move(fd), id});
  }
  return named;
}

Result<std::uint32_t> first_named(const GateLocation& place, Direction direction) {
  const auto named = named_programs(place, direction);
  if (!named) return std::unexpected(named.error());
  return named->empty() ? 0 : named->front().id;
}

Result<bool> is_in_order(std::uint32_t ifindex, Direction direction, std::uint32_t program) {
  const auto order = tcx_order(ifindex, direction);
  if (!order) return std::unexpected(order.error());
  return *order && (*order)->has(program);
}

Result<std::uint32_t> id_of(int program_fd) {
  errno = 0;
  const std::uint32_t id = program_info(program_fd).id;
  if (id == 0) return failure("ask for the number of a program", errno);
  return id;
}

Result<void> put_in_order(const GateLocation& place, Direction direction, int program_fd) {
  const auto id = id_of(program_fd);
  if (!id) return std::unexpected(id.error());
  const auto there = is_in_order(place.ifindex, direction, *id);
  if (!there) return std::unexpected(there.error());
  if (*there) return {};
  const auto former = named_programs(place, direction, *id);
  if (!former) return std::unexpected(former.error());
  return former->empty()
             ? tcx_attach_first(place.ifindex, direction, program_fd)
             : tcx_replace(place.ifindex, direction, former->front().fd.get(), program_fd);
}

/// If two processes race, the one that gets the name first holds the place.
Result<bool> put_in_empty_order(const GateLocation& place, Direction direction, int program_fd) {
  const auto there = first_named(place, direction);
  if (!there) return std::unexpected(there.error());
  if (*there != 0) return false;
  // The name may belong to a program that is attached nowhere.
  if (auto way = give_way(program_pin(place.directory, direction)); !way)
    return std::unexpected(way.error());
  if (auto put = tcx_attach_first(place.ifindex, direction, program_fd); !put)
    return std::unexpected(put.error());
  auto pinned = pin(program_fd, program_pin(place.directory, direction));
  if (!pinned || !*pinned) static_cast<void>(tcx_detach(place.ifindex, direction, program_fd));
  return pinned;
}

/// Up to layout 3 programs were held by BPF links: removing the links' pins detaches them at once.
Result<void> end_links_of_other_layouts(const GateLocation& place) {
  const std::filesystem::path directory(place.directory);
  const std::filesystem::path root = directory.parent_path().parent_path();
  const auto layouts = names_in(root.string());
  if (!layouts) return failure("read " + root.string(), layouts.error().value());
  for (const std::string& layout : *layouts) {
    if (layout == directory.parent_path().filename()) continue;
    const std::string left = root / layout / directory.filename();
    for (const char* name :
         {"/ingress_link", "/ingress_link_next", "/egress_link", "/egress_link_next"})
      if (const Fd link = open_pin(left + name); link) bpf_link_detach(link.get());
    remove_pin_directory(left);
  }
  return {};
}

/// Removes other programs of ours. They would obey their own control words, which get no heart-beat
/// any more, and drop everything. If they cannot be found out they stay, which is the safe side.
Result<void> remove_others_of_ours(const GateLocation& place, const InPlace& ours) {
  if (auto ended = end_links_of_other_layouts(place); !ended) return ended;
  for (const auto direction : kBothDirections) {
    const auto named = named_programs(place, direction, ours.of(direction));
    if (!named) return std::unexpected(named.error());
    for (const Named& former : *named)
      static_cast<void>(tcx_detach(place.ifindex, direction, former.fd.get()));
    static_cast<void>(remove_orphans(place.ifindex, direction, ours.of(direction)));
  }
  return {};
}

Result<bool> is_in_place(const GateLocation& place, Direction direction, std::uint32_t program) {
  if (place.hook == Hook::tcx) return is_in_order(place.ifindex, direction, program);
  const auto there = program_in_place(place.ifindex, direction);
  if (!there) return std::unexpected(there.error());
  return *there == program;
}

Result<bool> are_in_place(const GateLocation& place, const InPlace& ours) {
  for (const auto direction : kBothDirections) {
    const auto there = is_in_place(place, direction, ours.of(direction));
    if (!there || !*there) return there;
  }
  return true;
}

}  // namespace

Result<void> remove_orphans(std::uint32_t ifindex, Direction direction, std::uint32_t ours) {
  std::optional<std::map<std::uint32_t, bool>> gates;
  for (int i = 0; i < kTries; ++i) {
    const auto order = tcx_order(ifindex, direction);
    if (!order) return std::unexpected(order.error());
    if (!*order || (*order)->programs.size() < 2) return {};
    if (!gates) {
      auto found = programs_of_gates();
      if (!found) return std::unexpected(found.error());
      gates = std::move(*found);
    }
    const auto orphan = std::ranges::find_if((*order)->programs, [&](std::uint32_t program) {
      return program != ours && gates->contains(program);
    });
    if (orphan == (*order)->programs.end()) return {};
    // If the order has changed meanwhile, the loop tries again.
    static_cast<void>(tcx_detach_beside(ifindex, direction, **order, *orphan));
  }
  return {};
}

const char* to_text(Hook hook) { return hook == Hook::tcx ? "tcx" : "clsact"; }

Hook best_hook() { return kernel_has_tcx() ? Hook::tcx : Hook::clsact; }

Result<InPlace> ids_of(const GatePrograms& programs) {
  const auto in = id_of(programs.ingress);
  if (!in) return std::unexpected(in.error());
  const auto out = id_of(programs.egress);
  if (!out) return std::unexpected(out.error());
  return InPlace{.ingress = *in, .egress = *out};
}

Result<InPlace> in_place(const GateLocation& place) {
  const auto find = [&](Direction direction) {
    return place.hook == Hook::tcx ? first_named(place, direction)
                                   : program_in_place(place.ifindex, direction);
  };
  const auto in = find(Direction::ingress);
  if (!in) return std::unexpected(in.error());
  const auto out = find(Direction::egress);
  if (!out) return std::unexpected(out.error());
  return InPlace{.ingress = *in, .egress = *out};
}

Result<void> put_in_place(const GateLocation& place, Direction direction, int program_fd) {
  if (place.hook == Hook::clsact) {
    if (auto made = make_hooks(place.ifindex); !made) return made;
    return put_filter(place.ifindex, direction, program_fd);
  }
  return put_in_order(place, direction, program_fd);
}

Result<bool> put_in_empty_place(const GateLocation& place, Direction direction, int program_fd) {
  if (place.hook == Hook::tcx) return put_in_empty_order(place, direction, program_fd);
  if (auto made = make_hooks(place.ifindex); !made) return std::unexpected(made.error());
  return put_filter_if_empty(place.ifindex, direction, program_fd);
}

void withdraw(const GateLocation& place) {
  for (const auto direction : kBothDirections) {
    if (place.hook == Hook::clsact) {
      remove_filter(place.ifindex, direction);
      continue;
    }
    const auto named = named_programs(place, direction);
    if (!named) continue;
    for (const Named& program : *named)
      static_cast<void>(tcx_detach(place.ifindex, direction, program.fd.get()));
  }
}

Result<bool> are_in_place(const GateLocation& place, const GatePrograms& programs) {
  const auto ours = ids_of(programs);
  if (!ours) return std::unexpected(ours.error());
  return are_in_place(place, *ours);
}

Result<bool> are_both_removed(const GateLocation& place, const GatePrograms& programs) {
  const auto ours = ids_of(programs);
  if (!ours) return std::unexpected(ours.error());
  for (const auto direction : kBothDirections) {
    const auto there = is_in_place(place, direction, ours->of(direction));
    if (!there) return there;
    if (*there) return false;
  }
  return true;
}

Result<void> put_gate_in_place(const GateLocation& place, const GatePrograms& programs) {
  for (const auto direction : kBothDirections)
    if (auto put = put_in_place(place, direction, programs.of(direction)); !put) return put;
  const auto ours = ids_of(programs);
  if (!ours) return std::unexpected(ours.error());
  const auto there = are_in_place(place, *ours);
  if (!there) return std::unexpected(there.error());
  if (!*there)
    return fail(
        "the programs are not where they were put: remove the qdisc that stands in the place of "
        "clsact (tc qdisc show; tc qdisc del dev … ingress)");
  GateLocation other = place;
  other.hook = place.hook == Hook::tcx ? Hook::clsact : Hook::tcx;
  withdraw(other);
  return remove_others_of_ours(place, *ours);
}

Result<std::vector<Ahead>> tcx_ahead(const GateLocation& place, const InPlace& ours) {
  std::vector<Ahead> ahead;
  for (const auto direction : kBothDirections) {
    const auto order = tcx_order(place.ifindex, direction);
    if (!order) return std::unexpected(order.error());
    if (!*order) continue;
    for (const std::uint32_t program : (*order)->programs) {
      if (place.hook == Hook::tcx && program == ours.of(direction)) break;
      ahead.push_back({.direction = direction, .hook = Hook::tcx, .program = program});
    }
  }
  return ahead;
}

Result<void> put_gate_first(const GateLocation& place, const GatePrograms& programs,
                            const GatePrograms& former) {
  for (const auto direction : kBothDirections) {
    const auto put = place.hook == Hook::tcx
                         ? tcx_attach_first(place.ifindex, direction, programs.of(direction))
                         : put_filter_first(place.ifindex, direction, programs.of(direction));
    if (!put) return put;
    if (place.hook == Hook::tcx)  // it may be gone, which is a reason to be here
      static_cast<void>(tcx_detach(place.ifindex, direction, former.of(direction)));
  }
  if (place.hook != Hook::tcx) return {};
  const auto ours = ids_of(programs);
  if (!ours) return std::unexpected(ours.error());
  return remove_others_of_ours(place, *ours);
}

}  // namespace mlcca::gates
