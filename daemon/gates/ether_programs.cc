// SPDX-License-Identifier: BSD-2-Clause
// Sets the switches and sizes of the skeleton and loads it.
#include "daemon/gates/ether_programs.hpp"

#include <bpf/libbpf.h>
#include <ether.skel.h>

#include <cerrno>

#include "daemon/gates/complaints.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/programs.hpp"

namespace mlcca::enforce {
namespace {

std::array<bpf_map*, kEtherMaps.size()> maps_of(const ether_bpf& object) {
  return {object.maps.bss,       object.maps.buckets,
          object.maps.slots,     object.maps.contracts,
          object.maps.counts,    object.maps.cpus,
          object.maps.fragments, object.maps.foreign_fragments,
          object.maps.watches,   object.maps.ether_prefilter,
          object.maps.audits};
}

int set_sizes(const ether_bpf& object, const EtherSizes& sizes) {
  const std::array<std::pair<bpf_map*, std::uint32_t>, 10> entries{
      {{object.maps.buckets, sizes.buckets},
       {object.maps.slots, sizes.slots},
       {object.maps.contracts, sizes.contracts},
       {object.maps.counts, sizes.banks * sizes.slots},
       {object.maps.cpus, possible_cpus()},
       {object.maps.fragments, ether_fragment_entries(possible_cpus())},
       {object.maps.foreign_fragments, ether_fragment_entries(possible_cpus())},
       {object.maps.watches, ETHER_WATCHES},
       {object.maps.ether_prefilter, sizes.prefilters()},
       {object.maps.audits, sizes.slots}}};
  for (const auto& [map, count] : entries)
    if (const int error = bpf_map__set_max_entries(map, count); error != 0) return error;
  return 0;
}

int share_maps(const ether_bpf& object, const EtherSizes& sizes, const SharedMaps& shared,
               const EtherMaps& maps) {
  if (const int error = bpf_map__reuse_fd(object.maps.data_control, shared.control); error != 0)
    return error;
  if (const int error = bpf_map__reuse_fd(object.maps.events, shared.events); error != 0)
    return error;
  if (!maps.front()) return set_sizes(object, sizes);
  const auto all = maps_of(object);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (const int error = bpf_map__reuse_fd(all.at(i), maps.at(i).get()); error != 0) return error;
  return 0;
}

}  // namespace

std::string ether_map_pin(const std::string& directory, std::size_t n) {
  return directory + "/" + kEtherMaps.at(n);
}

std::optional<EtherPinned> pinned_ether_maps(const std::string& directory) {
  EtherPinned there;
  for (std::size_t n = 0; n < kEtherMaps.size(); ++n) {
    there.maps.at(n) = open_pin(ether_map_pin(directory, n));
    if (!there.maps.at(n)) return std::nullopt;
  }
  const int table_fd = there.maps.front().get();
  if (!is_mappable_array(table_fd, sizeof(ether_table), 1)) return std::nullopt;
  const Mapped<ether_table> table(table_fd, 1);
  if (!table || table[0].layout_version != ETHER_LAYOUT_VERSION) return std::nullopt;
  there.sizes = {table[0].slots, table[0].buckets, table[0].contracts, table[0].banks};
  const auto fits = [&](std::size_t n, std::uint32_t size, std::uint32_t entries) {
    return is_mappable_array(there.maps.at(n).get(), size, entries);
  };
  if (!fits(1, sizeof(std::uint64_t), there.sizes.buckets) ||
      !fits(2, sizeof(ether_slot), there.sizes.slots) ||
      !fits(3, sizeof(ether_contract), there.sizes.contracts) ||
      !fits(4, sizeof(gate_count), there.sizes.banks * there.sizes.slots) ||
      !fits(5, sizeof(ether_cpu), possible_cpus()) || !fits(8, sizeof(gate_watch), ETHER_WATCHES) ||
      !fits(9, sizeof(ether_prefilter_part), there.sizes.prefilters()) ||
      !fits(10, sizeof(gate_audit), there.sizes.slots))
    return std::nullopt;
  return there;
}

void destroy_ether_programs(ether_bpf* object) { ether_bpf__destroy(object); }

Result<EtherPrograms::Object> EtherPrograms::try_load(const EtherKnobs& knobs,
                                                      const EtherSizes& sizes,
                                                      const SharedMaps& shared,
                                                      const EtherMaps& maps, bool direct_access) {
  const Complaints complaints;
  Object object(ether_bpf__open());
  if (!object) return complaints.error("open the Ethernet gate", errno);
  object->rodata->ifindex = knobs.ifindex;
  object->rodata->silent = knobs.silent;
  object->rodata->bucket_mask = sizes.buckets - 1;
  object->rodata->slots_of_bank = sizes.slots;
  object->rodata->banks = sizes.banks;
  object->rodata->has_prefilter = sizes.has_prefilter();
  object->rodata->direct_access = direct_access;
  object->rodata->atomic_counts = is_preempt_rt();
  object->rodata->ordered_stores = kOrderedStores;
  if (const int error = share_maps(*object, sizes, shared, maps); error != 0)
    return complaints.error("prepare the maps of the Ethernet gate", error);
  if (const int error = ether_bpf__load(object.get()); error != 0)
    return complaints.error("load the Ethernet gate", error);
  return object;
}

Result<EtherPrograms> EtherPrograms::load(const EtherKnobs& knobs, const EtherSizes& sizes,
                                          const SharedMaps& shared, const EtherMaps& maps) {
  auto object = try_load(knobs, sizes, shared, maps, true);
  if (!object) object = try_load(knobs, sizes, shared, maps, false);
  if (!object) return std::unexpected(object.error());
  return EtherPrograms(std::move(*object));
}

int EtherPrograms::program_fd(Direction direction) const {
  return bpf_program__fd(direction == Direction::ingress ? object_->progs.ether_ingress
                                                         : object_->progs.ether_egress);
}
int EtherPrograms::early_fd() const { return bpf_program__fd(object_->progs.ether_early); }
int EtherPrograms::map_fd(std::size_t n) const { return bpf_map__fd(maps_of(*object_).at(n)); }

std::uint32_t& EtherPrograms::generation() const {
  return object_->data_control->control.generation;
}

Result<EtherMapping> EtherMapping::of(const EtherPrograms& programs, const EtherSizes& sizes) {
  EtherMapping m;
  m.generation_ = &programs.generation();
  m.table_ = {programs.map_fd(0), 1};
  m.buckets_ = {programs.map_fd(1), sizes.buckets};
  m.slots_ = {programs.map_fd(2), sizes.slots};
  m.contracts_ = {programs.map_fd(3), sizes.contracts};
  m.counts_ = {programs.map_fd(4), std::size_t{sizes.banks} * sizes.slots};
  m.cpus_ = {programs.map_fd(5), possible_cpus()};
  m.watches_ = {programs.map_fd(8), ETHER_WATCHES};
  m.prefilters_ = {programs.map_fd(9), sizes.prefilters()};
  m.audits_ = {programs.map_fd(10), sizes.slots};
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

}  // namespace mlcca::enforce
