// SPDX-License-Identifier: BSD-2-Clause
// Loads the skeleton of a gate, of either kind.
#pragma once
#include <bpf/libbpf.h>

#include <cerrno>
#include <string>

#include "base/result.hpp"
#include "daemon/gates/complaints.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/program_types.hpp"
#include "daemon/gates/programs.hpp"

namespace mlcca::gates {

/// Constants that are set in every gate before it is loaded.
struct GateSwitches {
  std::uint32_t ifindex = 0;
  bool silent = false;
};

/// `prepare` sets the constants and maps of one kind; it returns 0 or a negative errno.
template <class Skeleton, class Object>
Result<Object> try_load_gate(const std::string& what, const GateSwitches& switches,
                             const SharedMaps& shared, bool direct_access, const auto& prepare) {
  if (auto demanded = demand_types(); !demanded) return std::unexpected(demanded.error());
  const Complaints complaints;
  Object object(Skeleton::open());
  if (!object) return complaints.error("open " + what, errno);
  object->rodata->ifindex = switches.ifindex;
  object->rodata->silent = switches.silent;
  object->rodata->direct_access = direct_access;
  object->rodata->atomic_counts = is_preempt_rt();
  object->rodata->ordered_stores = kOrderedStores;
  int error = bpf_map__reuse_fd(object->maps.data_control, shared.control);
  if (error == 0) error = bpf_map__reuse_fd(object->maps.events, shared.events);
  if (error == 0) error = prepare(*object);
  if (error != 0) return complaints.error("prepare the maps of " + what, error);
  error = Skeleton::load(object.get());
  if (error != 0) return complaints.error("load " + what, error);
  return object;
}

/// Loads with direct packet access first. The verifier refuses packet pointers on machines that
/// cannot read unaligned words; there the second attempt succeeds.
template <class Skeleton, class Object>
Result<Object> load_gate(const std::string& what, const GateSwitches& switches,
                         const SharedMaps& shared, const auto& prepare) {
  auto object = try_load_gate<Skeleton, Object>(what, switches, shared, true, prepare);
  return object ? std::move(object)
                : try_load_gate<Skeleton, Object>(what, switches, shared, false, prepare);
}

}  // namespace mlcca::gates
