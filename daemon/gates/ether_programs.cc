// SPDX-License-Identifier: BSD-2-Clause
// Sets the constants and sizes of the skeleton, and loads it.
#include "daemon/gates/ether_programs.hpp"

#include <bpf/libbpf.h>
#include <ether.skel.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "daemon/gates/failure.hpp"
#include "daemon/gates/gate_maps.hpp"
#include "daemon/gates/load_gate.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/programs.hpp"

namespace mlcca::gates {
namespace {

using Maps = decltype(ether_bpf::maps);

/// A row of the table of maps. Maps that are mapped into memory state the size of their values.
struct Row : MapRow<EtherMaps, ether_bpf> {
  std::uint32_t value_size = 0;  ///< 0: not mapped
  std::uint32_t (*entries)(const EtherSizes&) = nullptr;
};
constexpr auto kFragments = [](const EtherSizes&) {
  return ether_fragment_entries(possible_cpus());
};
constexpr std::array kMaps = {
    Row{{&EtherMaps::table, "ether_table", &Maps::bss},
        sizeof(ether_table),
        [](const EtherSizes&) { return 1U; }},
    Row{{&EtherMaps::buckets, "ether_buckets", &Maps::buckets},
        sizeof(std::uint64_t),
        [](const EtherSizes& s) { return s.buckets; }},
    Row{{&EtherMaps::slots, "ether_slots", &Maps::slots},
        sizeof(ether_slot),
        [](const EtherSizes& s) { return s.slots; }},
    Row{{&EtherMaps::contracts, "ether_contracts", &Maps::contracts},
        sizeof(ether_contract),
        [](const EtherSizes& s) { return s.contracts; }},
    Row{{&EtherMaps::counts, "ether_counts", &Maps::counts},
        sizeof(gate_count),
        [](const EtherSizes& s) { return s.banks * s.slots; }},
    Row{{&EtherMaps::cpus, "ether_cpus", &Maps::cpus},
        sizeof(ether_cpu),
        [](const EtherSizes&) { return possible_cpus(); }},
    Row{{&EtherMaps::fragments, "ether_fragments", &Maps::fragments}, 0, kFragments},
    Row{{&EtherMaps::foreign_fragments, "ether_foreign", &Maps::foreign_fragments}, 0, kFragments},
    Row{{&EtherMaps::watches, "ether_watches", &Maps::watches},
        sizeof(gate_watch),
        [](const EtherSizes&) { return std::uint32_t{ETHER_WATCHES}; }},
    Row{{&EtherMaps::prefilter, "ether_prefilter", &Maps::ether_prefilter},
        sizeof(ether_prefilter_part),
        [](const EtherSizes& s) { return s.prefilters(); }},
    Row{{&EtherMaps::audits, "ether_audits", &Maps::audits},
        sizeof(gate_audit),
        [](const EtherSizes& s) { return s.slots; }}};

int set_sizes(const ether_bpf& object, const EtherSizes& sizes) {
  for (const Row& row : kMaps) {
    if (row.map == &Maps::bss) continue;  // always one value
    if (const int error = bpf_map__set_max_entries(object.maps.*row.map, row.entries(sizes));
        error != 0)
      return error;
  }
  return 0;
}

bool fits(const Row& row, const EtherPinned& there) {
  return row.value_size == 0 ||
         is_mappable_array((there.maps.*row.fd).get(), row.value_size, row.entries(there.sizes));
}

/// The maps with their sizes, which the table states; nullopt if they are not of this layout.
std::optional<EtherPinned> of_this_layout(std::optional<EtherMaps> maps) {
  if (!maps || !is_mappable_array(maps->table.get(), sizeof(ether_table), 1)) return std::nullopt;
  const Mapped<ether_table> table(maps->table.get(), 1);
  if (!table || table[0].layout_version != ETHER_LAYOUT_VERSION) return std::nullopt;
  EtherPinned there{std::move(*maps),
                    {table[0].slots, table[0].buckets, table[0].contracts, table[0].banks}};
  if (!std::ranges::all_of(kMaps, [&](const Row& row) { return fits(row, there); }))
    return std::nullopt;
  return there;
}

}  // namespace

std::string ether_map_pin(const std::string& directory, Fd EtherMaps::* map) {
  return directory + "/" + std::ranges::find(kMaps, map, &Row::fd)->pin;
}

std::optional<EtherPinned> pinned_ether_maps(const std::string& directory) {
  return of_this_layout(open_maps<EtherMaps>(kMaps, directory, open_pin));
}
std::optional<EtherPinned> take_ether_maps(const std::string& directory, const MapIds& ids) {
  return of_this_layout(take_maps<EtherMaps>(kMaps, directory, ids));
}

void destroy_ether_programs(ether_bpf* object) { ether_bpf__destroy(object); }

Result<EtherPrograms> EtherPrograms::load(const EtherKnobs& knobs, const EtherSizes& sizes,
                                          const SharedMaps& shared, const EtherMaps& maps) {
  auto object = load_gate<ether_bpf, Object>(
      "the Ethernet gate", {knobs.ifindex, knobs.silent}, shared, [&](const ether_bpf& gate) {
        gate.rodata->bucket_mask = sizes.buckets - 1;
        gate.rodata->slots_of_bank = sizes.slots;
        gate.rodata->banks = sizes.banks;
        gate.rodata->has_prefilter = sizes.has_prefilter();
        gate.rodata->is_wpan = knobs.wpan;
        return maps.table ? reuse_maps(kMaps, gate, maps) : set_sizes(gate, sizes);
      });
  if (!object) return std::unexpected(object.error());
  return EtherPrograms(std::move(*object));
}

std::vector<Pin> EtherPrograms::pins(const std::string& directory) const {
  return pins_of(kMaps, *object_, directory);
}
Result<EtherMaps> EtherPrograms::share() const { return share_maps<EtherMaps>(kMaps, *object_); }

int EtherPrograms::program_fd(Direction direction) const {
  return bpf_program__fd(direction == Direction::ingress ? object_->progs.ether_ingress
                                                         : object_->progs.ether_egress);
}
int EtherPrograms::early_fd() const { return bpf_program__fd(object_->progs.ether_early); }
int EtherPrograms::map_fd(Fd EtherMaps::* map) const {
  return bpf_map__fd(object_->maps.*std::ranges::find(kMaps, map, &Row::fd)->map);
}

std::uint32_t& EtherPrograms::generation() const {
  return object_->data_control->control.generation;
}

Result<EtherMapping> EtherMapping::of(const EtherPrograms& programs, const EtherSizes& sizes) {
  EtherMapping m;
  m.generation_ = &programs.generation();
  m.table_ = {programs.map_fd(&EtherMaps::table), 1};
  m.buckets_ = {programs.map_fd(&EtherMaps::buckets), sizes.buckets};
  m.slots_ = {programs.map_fd(&EtherMaps::slots), sizes.slots};
  m.contracts_ = {programs.map_fd(&EtherMaps::contracts), sizes.contracts};
  m.counts_ = {programs.map_fd(&EtherMaps::counts), std::size_t{sizes.banks} * sizes.slots};
  m.cpus_ = {programs.map_fd(&EtherMaps::cpus), possible_cpus()};
  m.watches_ = {programs.map_fd(&EtherMaps::watches), ETHER_WATCHES};
  m.prefilters_ = {programs.map_fd(&EtherMaps::prefilter), sizes.prefilters()};
  m.audits_ = {programs.map_fd(&EtherMaps::audits), sizes.slots};
  if (!m.table_ || !m.buckets_ || !m.prefilters_ || !m.slots_ || !m.contracts_ || !m.counts_ ||
      !m.cpus_ || !m.watches_ || !m.audits_)
    return failure("map the memory of the Ethernet gate", errno);
  return m;
}

EtherMemory EtherMapping::memory() const {
  return {.table = table_.span().data(),
          .buckets = buckets_.span(),
          .prefilters = prefilters_.span(),
          .slots = slots_.span(),
          .contracts = contracts_.span(),
          .counts = counts_.span(),
          .audits = audits_.span(),
          .watches = watches_.span(),
          .generation = generation_};
}

}  // namespace mlcca::gates
