// SPDX-License-Identifier: BSD-2-Clause
// Sets the constants of the gate's skeleton, and loads it.
#include "daemon/gates/programs.hpp"

#include <bpf/libbpf.h>
#include <gate.skel.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "daemon/gates/gate_maps.hpp"
#include "daemon/gates/load_gate.hpp"

namespace mlcca::gates {
namespace {

using Row = MapRow<GateMaps, gate_bpf>;
using Maps = decltype(gate_bpf::maps);
constexpr std::array kMaps = {Row{&GateMaps::table, kTablePin, &Maps::bss},
                              Row{&GateMaps::cpus, kCpusPin, &Maps::cpus}};

}  // namespace

std::uint32_t gate_profile_of(core::Profile profile) { return static_cast<std::uint32_t>(profile); }
core::Profile core_profile_of(std::uint32_t profile) {
  return profile < core::kProfileCount ? static_cast<core::Profile>(profile) : core::Profile::none;
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

std::optional<GateMaps> take_gate_maps(const std::string& directory, const MapIds& ids) {
  auto maps = take_maps<GateMaps>(kMaps, directory, ids);
  if (!maps || !is_mappable_array(maps->table.get(), sizeof(gate_table), 1) ||
      !is_mappable_array(maps->cpus.get(), sizeof(gate_cpu), possible_cpus()))
    return std::nullopt;
  return maps;
}

Result<Programs> Programs::load(const ProgramConfig& config, const SharedMaps& shared,
                                const GateMaps& maps) {
  auto object = load_gate<gate_bpf, Object>(
      "the gate", {config.ifindex, config.silent}, shared, [&](const gate_bpf& gate) {
        gate.rodata->profile = config.profile;
        gate.rodata->echo_by_mark = config.echo_by_mark;
        return maps.table ? reuse_maps(kMaps, gate, maps)
                          : bpf_map__set_max_entries(gate.maps.cpus, possible_cpus());
      });
  if (!object) return std::unexpected(object.error());
  return Programs(std::move(*object));
}

std::vector<Pin> Programs::pins(const std::string& directory) const {
  return pins_of(kMaps, *object_, directory);
}
Result<GateMaps> Programs::share() const { return share_maps<GateMaps>(kMaps, *object_); }
int Programs::program_fd(Direction direction) const {
  return bpf_program__fd(direction == Direction::ingress ? object_->progs.gate_ingress
                                                         : object_->progs.gate_egress);
}
int Programs::table_fd() const { return bpf_map__fd(object_->maps.bss); }
int Programs::cpus_fd() const { return bpf_map__fd(object_->maps.cpus); }
gate_table& Programs::table() const { return object_->bss->table; }
std::uint32_t& Programs::generation() const { return object_->data_control->control.generation; }

}  // namespace mlcca::gates
