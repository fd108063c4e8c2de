// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/gate_pins.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "daemon/gates/attachment.hpp"

namespace mlcca::gates {
namespace {

/// The maps of an attached program of one direction, and whether it had only its next name, which
/// becomes its own.
struct Attached {
  MapIds maps;
  bool was_next = false;
};
Result<std::optional<Attached>> attached_program(const std::string& directory, Direction direction,
                                                 std::uint32_t id) {
  if (id == 0) return std::nullopt;
  const std::string own = program_pin(directory, direction);
  for (const bool next : {true, false}) {
    const Fd program = open_pin(next ? next_of(own) : own);
    if (!program || !is_program(program.get())) continue;
    auto info = program_info(program.get());
    if (info.id != id) continue;
    if (next)
      if (auto named = rename_pin(next_of(own), own); !named) return std::unexpected(named.error());
    return Attached{.maps = std::move(info.map_ids), .was_next = next};
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<MapIds>> maps_of_attached(const std::string& directory, std::uint32_t ifindex) {
  std::vector<MapIds> found;
  for (const auto hook : {Hook::tcx, Hook::clsact}) {
    const auto attached = in_place({ifindex, directory, hook});
    if (!attached) return std::unexpected(attached.error());
    for (const auto direction : kBothDirections) {
      auto program = attached_program(directory, direction, attached->of(direction));
      if (!program) return std::unexpected(program.error());
      if (!*program) continue;
      found.insert((*program)->was_next ? found.begin() : found.end(), std::move((*program)->maps));
    }
  }
  return found;
}

Fd take_map(const std::string& path, const MapIds& ids) {
  for (const bool next : {false, true}) {
    Fd map = open_pin(next ? next_of(path) : path);
    if (!map || std::ranges::find(ids, map_id(map.get())) == ids.end()) continue;
    // If that fails, it gets the name together with those of the programs.
    if (next) static_cast<void>(rename_pin(next_of(path), path));
    return map;
  }
  return {};
}

Result<void> pin_as_next(std::span<const Pin> pins) {
  for (const Pin& given : pins) {
    const std::string next = next_of(given.path);
    if (auto way = give_way(next); !way) return std::unexpected(way.error());
    if (is_pinned(given)) continue;
    if (auto pinned = pin_instead(given.fd, next); !pinned) return std::unexpected(pinned.error());
  }
  return {};
}

Result<void> name_next(std::span<const Pin> pins) {
  for (const Pin& given : pins) {
    // An object that already has its own name has no next one.
    if (what_is_at(next_of(given.path)).empty()) continue;
    if (auto named = rename_pin(next_of(given.path), given.path); !named) return named;
  }
  return {};
}

void forget_next(const std::string& directory) {
  const auto names = names_in(directory);
  if (!names) return;
  for (const std::string& name : *names)
    if (name.ends_with(next_of(""))) remove_pin(fmt::format("{}/{}", directory, name));
}

}  // namespace mlcca::gates
