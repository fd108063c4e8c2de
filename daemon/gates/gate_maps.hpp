// SPDX-License-Identifier: BSD-2-Clause
// The maps of a gate that outlive a daemon, as rows of a table that both kinds of gate use: where
// the descriptor is kept, the name of the pin, and the map of the skeleton.
#pragma once
#include <bpf/libbpf.h>
#include <fcntl.h>

#include <cerrno>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::gates {

/// `Maps` is a struct of descriptors, `Skeleton` that of the gate's object.
template <class Maps, class Skeleton>
struct MapRow {
  Fd Maps::* fd;
  const char* pin;
  bpf_map* decltype(Skeleton::maps)::* map;
};

/// Opens all maps by `open`, which gets the path of each pin; nullopt if one is not there.
template <class Maps>
std::optional<Maps> open_maps(const auto& rows, const std::string& directory, const auto& open) {
  Maps maps;
  for (const auto& row : rows) {
    maps.*row.fd = open(directory + "/" + row.pin);
    if (!(maps.*row.fd)) return std::nullopt;
  }
  return maps;
}

/// The maps of the attached gate: see take_map().
template <class Maps>
std::optional<Maps> take_maps(const auto& rows, const std::string& directory, const MapIds& ids) {
  return open_maps<Maps>(rows, directory,
                         [&](const std::string& path) { return take_map(path, ids); });
}

template <class Skeleton>
std::vector<Pin> pins_of(const auto& rows, const Skeleton& object, const std::string& directory) {
  std::vector<Pin> pins;
  pins.reserve(std::size(rows));
  for (const auto& row : rows)
    pins.push_back({bpf_map__fd(object.maps.*row.map), directory + "/" + row.pin});
  return pins;
}

/// Further descriptors of the maps, for a second object with the same memory.
template <class Maps, class Skeleton>
Result<Maps> share_maps(const auto& rows, const Skeleton& object) {
  Maps maps;
  for (const auto& row : rows) {
    maps.*row.fd = Fd(::fcntl(bpf_map__fd(object.maps.*row.map), F_DUPFD_CLOEXEC, 0));
    if (!(maps.*row.fd)) return failure("share the maps of a gate", errno);
  }
  return maps;
}

/// Makes a skeleton use existing maps. 0 or a negative errno.
template <class Maps, class Skeleton>
int reuse_maps(const auto& rows, const Skeleton& object, const Maps& maps) {
  for (const auto& row : rows)
    if (const int error = bpf_map__reuse_fd(object.maps.*row.map, (maps.*row.fd).get()); error != 0)
      return error;
  return 0;
}

}  // namespace mlcca::gates
