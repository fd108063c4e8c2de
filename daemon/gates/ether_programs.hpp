// SPDX-License-Identifier: BSD-2-Clause
// The programs and maps of an Ethernet gate in the kernel.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "bpf/ether.h"
#include "daemon/gates/control.hpp"
#include "daemon/gates/ether_table.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/slots.hpp"

struct ether_bpf;  // NOLINT(readability-identifier-naming): the skeleton's name

namespace mlcca::gates {

void destroy_ether_programs(ether_bpf* object);

/// The maps of one interface that outlive a daemon: all are set, or none.
struct EtherMaps {
  Fd table;
  Fd buckets;
  Fd slots;
  Fd contracts;
  Fd counts;
  Fd cpus;
  Fd fragments;
  Fd foreign_fragments;
  Fd watches;
  Fd prefilter;
  Fd audits;
};
/// The path of the pin of a map.
std::string ether_map_pin(const std::string& directory, Fd EtherMaps::* map);

/// Maps that were found pinned, with the sizes that their table states.
struct EtherPinned {
  EtherMaps maps;
  EtherSizes sizes;
};
/// The pinned maps of an interface; nullopt if one is missing, has another layout, or does not fit
/// the others.
std::optional<EtherPinned> pinned_ether_maps(const std::string& directory);
/// The maps of the attached gate: see take_map().
std::optional<EtherPinned> take_ether_maps(const std::string& directory, const MapIds& ids);

/// Constants of the programs that are set before they are loaded.
struct EtherKnobs {
  std::uint32_t ifindex = 0;
  bool silent = false;
  bool wpan = false;  ///< frames of IEEE 802.15.4, not of Ethernet
};

/// Loads the programs of an Ethernet gate, and owns them.
class EtherPrograms {
 public:
  /// Loads the programs with `maps`, or with new ones if these are empty.
  static Result<EtherPrograms> load(const EtherKnobs& knobs, const EtherSizes& sizes,
                                    const SharedMaps& shared, const EtherMaps& maps);

  [[nodiscard]] int program_fd(Direction direction) const;
  /// The descriptor of the XDP program.
  [[nodiscard]] int early_fd() const;
  [[nodiscard]] int map_fd(Fd EtherMaps::* map) const;
  /// The maps that outlive a daemon, with the paths of their pins.
  [[nodiscard]] std::vector<Pin> pins(const std::string& directory) const;
  /// Further descriptors of the same maps.
  [[nodiscard]] Result<EtherMaps> share() const;
  /// The generation of the verdicts, in the control map.
  [[nodiscard]] std::uint32_t& generation() const;

 private:
  using Object = std::unique_ptr<ether_bpf, FreeWith<destroy_ether_programs>>;
  explicit EtherPrograms(Object object) : object_(std::move(object)) {}
  Object object_;
};

/// The maps' memory, mapped into this process. It must not outlive the programs.
class EtherMapping {
 public:
  static Result<EtherMapping> of(const EtherPrograms& programs, const EtherSizes& sizes);
  [[nodiscard]] EtherMemory memory() const;
  [[nodiscard]] std::span<ether_cpu> cpus() const { return cpus_.span(); }

 private:
  std::uint32_t* generation_ = nullptr;  ///< owned by the programs
  Mapped<ether_table> table_;
  Mapped<std::uint64_t> buckets_;
  Mapped<ether_prefilter_part> prefilters_;
  Mapped<ether_slot> slots_;
  Mapped<ether_contract> contracts_;
  Mapped<gate_count> counts_;
  Mapped<gate_audit> audits_;
  Mapped<ether_cpu> cpus_;
  Mapped<gate_watch> watches_;
};

}  // namespace mlcca::gates
