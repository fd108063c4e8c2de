// SPDX-License-Identifier: BSD-2-Clause
// Sets the switches of the gate's skeleton and loads it.
#include "daemon/gates/programs.hpp"

#include <bpf/libbpf.h>
#include <gate.skel.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>

#include "daemon/gates/complaints.hpp"

namespace mlcca::enforce {
namespace {

struct KnownProfile {
  core::Profile core;
  std::uint32_t gate;
};
constexpr std::array kProfiles = {KnownProfile{core::Profile::raw, GATE_PROFILE_RAW},
                                  KnownProfile{core::Profile::famouso, GATE_PROFILE_FAMOUSO},
                                  KnownProfile{core::Profile::j1939, GATE_PROFILE_J1939},
                                  KnownProfile{core::Profile::cyphal, GATE_PROFILE_CYPHAL},
                                  KnownProfile{core::Profile::canopen, GATE_PROFILE_CANOPEN}};

int share_maps(gate_bpf& object, const SharedMaps& shared, const GateMaps& maps) {
  if (const int error = bpf_map__reuse_fd(object.maps.data_control, shared.control); error != 0)
    return error;
  if (const int error = bpf_map__reuse_fd(object.maps.events, shared.events); error != 0)
    return error;
  if (!maps.table) return bpf_map__set_max_entries(object.maps.cpus, possible_cpus());
  if (const int error = bpf_map__reuse_fd(object.maps.bss, maps.table.get()); error != 0)
    return error;
  return bpf_map__reuse_fd(object.maps.cpus, maps.cpus.get());
}

}  // namespace

std::uint32_t gate_profile_of(core::Profile profile) {
  const auto* const known = std::ranges::find(kProfiles, profile, &KnownProfile::core);
  return known == kProfiles.end() ? std::uint32_t{GATE_PROFILE_NONE} : known->gate;
}
core::Profile core_profile_of(std::uint32_t profile) {
  const auto* const known = std::ranges::find(kProfiles, profile, &KnownProfile::gate);
  return known == kProfiles.end() ? core::Profile::none : known->core;
}

void destroy_programs(gate_bpf* object) { gate_bpf__destroy(object); }

bool is_preempt_rt() {
  utsname kernel{};
  return uname(&kernel) == 0 &&
         std::string_view(kernel.version).find("PREEMPT_RT") != std::string_view::npos;
}

std::uint32_t possible_cpus() {
  return static_cast<std::uint32_t>(std::max(libbpf_num_possible_cpus(), 1));
}

Result<Programs::Object> Programs::try_load(const ProgramConfig& config, const SharedMaps& shared,
                                            const GateMaps& maps, bool direct_access) {
  const Complaints complaints;
  Object object(gate_bpf__open());
  if (!object) return complaints.error("open the gate", errno);
  object->rodata->ifindex = config.ifindex;
  object->rodata->profile = config.profile;
  object->rodata->echo_by_mark = config.echo_by_mark;
  object->rodata->silent = config.silent;
  object->rodata->direct_access = direct_access;
  object->rodata->atomic_counts = is_preempt_rt();
  object->rodata->ordered_stores = kOrderedStores;
  if (const int error = share_maps(*object, shared, maps); error != 0)
    return complaints.error("prepare the gate's maps", error);
  if (const int error = gate_bpf__load(object.get()); error != 0)
    return complaints.error("load the gate", error);
  return object;
}

/// The verifier refuses packet pointers on machines that cannot read unaligned words.
Result<Programs> Programs::load(const ProgramConfig& config, const SharedMaps& shared,
                                const GateMaps& maps) {
  auto object = try_load(config, shared, maps, true);
  if (!object) object = try_load(config, shared, maps, false);
  if (!object) return std::unexpected(object.error());
  return Programs(std::move(*object));
}

int Programs::program_fd(Direction direction) const {
  return bpf_program__fd(direction == Direction::ingress ? object_->progs.gate_ingress
                                                         : object_->progs.gate_egress);
}
int Programs::table_fd() const { return bpf_map__fd(object_->maps.bss); }
int Programs::cpus_fd() const { return bpf_map__fd(object_->maps.cpus); }
gate_table& Programs::table() const { return object_->bss->table; }
std::uint32_t& Programs::generation() const { return object_->data_control->control.generation; }

}  // namespace mlcca::enforce
