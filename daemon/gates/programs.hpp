// SPDX-License-Identifier: BSD-2-Clause
// The programs and maps of a CAN gate in the kernel.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "bpf/gate.h"
#include "core/model/system.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/slots.hpp"

struct gate_bpf;  // NOLINT(readability-identifier-naming): the skeleton's name

namespace mlcca::gates {

void destroy_programs(gate_bpf* object);

std::uint32_t gate_profile_of(core::Profile profile);
/// The inverse of gate_profile_of(); Profile::none for a number that is no profile.
core::Profile core_profile_of(std::uint32_t profile);

/// The maps of one interface: both are set, or none.
struct GateMaps {
  Fd table;
  Fd cpus;
};
/// The maps of the attached gate: see take_map(). nullopt if they do not exist or have another
/// layout.
std::optional<GateMaps> take_gate_maps(const std::string& directory, const MapIds& ids);

/// Constants of the programs that are set before they are loaded.
struct ProgramConfig {
  std::uint32_t ifindex = 0;
  std::uint32_t profile = GATE_PROFILE_NONE;
  bool echo_by_mark = false;
  bool silent = false;
};

/// Loads the programs of a CAN gate, and owns them.
class Programs {
 public:
  /// Loads the programs with `maps`, or with new ones if these are empty.
  static Result<Programs> load(const ProgramConfig& config, const SharedMaps& shared,
                               const GateMaps& maps);

  [[nodiscard]] int program_fd(Direction direction) const;
  /// The maps that outlive a daemon, with the paths of their pins.
  [[nodiscard]] std::vector<Pin> pins(const std::string& directory) const;
  [[nodiscard]] Result<GateMaps> share() const;
  [[nodiscard]] int table_fd() const;
  [[nodiscard]] int cpus_fd() const;
  [[nodiscard]] gate_table& table() const;
  /// The generation of the verdicts, in the control map.
  [[nodiscard]] std::uint32_t& generation() const;

 private:
  using Object = std::unique_ptr<gate_bpf, FreeWith<destroy_programs>>;
  explicit Programs(Object object) : object_(std::move(object)) {}
  Object object_;
};

/// Whether a BPF program can be preempted by another one on its CPU (PREEMPT_RT).
bool is_preempt_rt();

/// Whether other CPUs see the stores of one CPU in its order (x86: total store order).
#if defined(__x86_64__) || defined(__i386__)
inline constexpr bool kOrderedStores = true;
#else
inline constexpr bool kOrderedStores = false;
#endif

/// The number of possible CPUs of this machine, which is the number of entries of the counters map.
std::uint32_t possible_cpus();

}  // namespace mlcca::gates
