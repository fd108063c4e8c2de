// SPDX-License-Identifier: BSD-2-Clause
// The maps of a gate that outlive a daemon, by name: a row for each says where its descriptor is
// kept, how it is pinned, and which map of the skeleton it is. Of either kind of gate.
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

namespace mlcca::enforce {

/// `Maps`: a struct of descriptors. `Skeleton`: of the gate's object.
template <class Maps, class Skeleton>
struct MapRow {
  Fd Maps::* fd;
  const char* pin;
  bpf_map* decltype(Skeleton::maps)::* map;
};

/// All of them as `open` gives each by the path of its pin, or nothing.
template <class Maps>
std::optional<Maps> open_maps(const auto& rows, const std::string& directory, const auto& open) {
  Maps maps;
  for (const auto& row : rows) {
    maps.*row.fd = open(directory + "/" + row.pin);
    if (!(maps.*row.fd)) return std::nullopt;
  }
  return maps;
}

/// Those of the gate that is attached: see take_map().
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

/// For a second object over the same memory.
template <class Maps, class Skeleton>
Result<Maps> share_maps(const auto& rows, const Skeleton& object) {
  Maps maps;
  for (const auto& row : rows) {
    maps.*row.fd = Fd(::fcntl(bpf_map__fd(object.maps.*row.map), F_DUPFD_CLOEXEC, 0));
    if (!(maps.*row.fd)) return failure("share the maps of a gate", errno);
  }
  return maps;
}

/// 0 or a negative errno.
template <class Maps, class Skeleton>
int reuse_maps(const auto& rows, const Skeleton& object, const Maps& maps) {
  for (const auto& row : rows)
    if (const int error = bpf_map__reuse_fd(object.maps.*row.map, (maps.*row.fd).get()); error != 0)
      return error;
  return 0;
}

}  // namespace mlcca::enforce
