// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/starting.hpp"

#include <bpf/bpf.h>

#include <cerrno>
#include <utility>

#include "daemon/gates/failure.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::gates {
namespace {

Result<Fd> open_note(const std::string& path) {
  const auto is_ours = [](int map) { return is_mappable_array(map, sizeof(std::uint64_t), 1); };
  std::string was;
  auto there = open_own(path, is_ours, was);
  if (!there || *there) return there;
  LIBBPF_OPTS(bpf_map_create_opts, options, .map_flags = BPF_F_MMAPABLE);
  Fd made(bpf_map_create(BPF_MAP_TYPE_ARRAY, "mlcca_starting", sizeof(std::uint32_t),
                         sizeof(std::uint64_t), 1, &options));
  if (!made) return failure("make " + path, errno);
  if (auto pinned = pin_instead(made.get(), path); !pinned) return std::unexpected(pinned.error());
  return made;
}

}  // namespace

Result<Starting> Starting::begin(const Control& control, std::uint64_t limit, std::uint64_t now) {
  auto map = open_note(control.directory() + "/starting");
  if (!map) return std::unexpected(map.error());
  Mapped<std::uint64_t> began(map->get(), 1);
  if (!began) return failure("map the note of a start", errno);
  // A time in the future was not written with this clock.
  if (began[0] == 0 || began[0] > now) began[0] = now;
  return Starting(std::move(*map), std::move(began), limit);
}

bool Starting::beat(Control& control, std::uint64_t now) {
  if (!control.is_open() || control.lapsed() || now - began_[0] >= limit_) return false;
  return control.beat(now).has_value();
}

void Starting::finish() { began_[0] = 0; }

}  // namespace mlcca::gates
