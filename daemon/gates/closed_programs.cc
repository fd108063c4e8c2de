// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/closed_programs.hpp"

#include <bpf/libbpf.h>
#include <ether_closed.skel.h>
#include <fcntl.h>
#include <gate_closed.skel.h>

#include <cerrno>
#include <memory>
#include <utility>

#include "bpf/ether.h"
#include "daemon/gates/complaints.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/programs.hpp"

namespace mlcca::gates {
namespace {

template <class Skeleton>
using Object = std::unique_ptr<Skeleton, decltype(&Skeleton::destroy)>;

}  // namespace

Result<ClosedPrograms> ClosedPrograms::keep(int ingress, int egress) {
  // NOLINTBEGIN(*-vararg)
  Fd in(::fcntl(ingress, F_DUPFD_CLOEXEC, 0));
  Fd out(::fcntl(egress, F_DUPFD_CLOEXEC, 0));
  // NOLINTEND(*-vararg)
  if (!in || !out) return failure("keep the closed gate", errno);
  return ClosedPrograms(std::move(in), std::move(out));
}

Result<ClosedPrograms> ClosedPrograms::of_can(const SharedMaps& shared) {
  const Complaints complaints;
  const Object<gate_closed_bpf> object(gate_closed_bpf::open(), &gate_closed_bpf::destroy);
  if (!object) return complaints.error("open the closed gate", errno);
  if (const int error = bpf_map__reuse_fd(object->maps.data_control, shared.control); error != 0)
    return complaints.error("prepare the maps of the closed gate", error);
  if (const int error = gate_closed_bpf::load(object.get()); error != 0)
    return complaints.error("load the closed gate", error);
  return keep(bpf_program__fd(object->progs.closed_ingress),
              bpf_program__fd(object->progs.closed_egress));
}

Result<ClosedPrograms> ClosedPrograms::of_ethernet(const SharedMaps& shared, bool wpan) {
  const Complaints complaints;
  const Object<ether_closed_bpf> object(ether_closed_bpf::open(), &ether_closed_bpf::destroy);
  if (!object) return complaints.error("open the closed gate", errno);
  object->rodata->is_wpan = wpan;
  int error = bpf_map__reuse_fd(object->maps.data_control, shared.control);
  if (error == 0)
    error = bpf_map__set_max_entries(object->maps.foreign_fragments,
                                     ether_fragment_entries(possible_cpus()));
  if (error != 0) return complaints.error("prepare the maps of the closed gate", error);
  if (error = ether_closed_bpf::load(object.get()); error != 0)
    return complaints.error("load the closed gate", error);
  return keep(bpf_program__fd(object->progs.closed_ingress),
              bpf_program__fd(object->progs.closed_egress));
}

}  // namespace mlcca::gates
