// SPDX-License-Identifier: BSD-2-Clause
// The gate's object in the kernel: two programs and the maps they read.
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

namespace mlcca::enforce {

void destroy_programs(gate_bpf* object);

std::uint32_t gate_profile_of(core::Profile profile);
/// Its inverse; none for a number that is no profile.
core::Profile core_profile_of(std::uint32_t profile);

/// The per-interface maps; both or none.
struct GateMaps {
  Fd table;
  Fd cpus;
};
/// Those of the gate that is attached: see take_map(). Nothing where they are not there, or of
/// another layout.
std::optional<GateMaps> take_gate_maps(const std::string& directory, const MapIds& ids);

struct ProgramConfig {
  std::uint32_t ifindex = 0;
  std::uint32_t profile = GATE_PROFILE_NONE;
  bool echo_by_mark = false;
  bool silent = false;
};

class Programs {
 public:
  /// Loads over `maps`, or over new ones where they are empty.
  static Result<Programs> load(const ProgramConfig& config, const SharedMaps& shared,
                               const GateMaps& maps);

  [[nodiscard]] int program_fd(Direction direction) const;
  /// Of the maps that outlive a daemon.
  [[nodiscard]] std::vector<Pin> pins(const std::string& directory) const;
  [[nodiscard]] Result<GateMaps> share() const;
  [[nodiscard]] int table_fd() const;
  [[nodiscard]] int cpus_fd() const;
  [[nodiscard]] gate_table& table() const;
  /// Of the control map.
  [[nodiscard]] std::uint32_t& generation() const;

 private:
  using Object = std::unique_ptr<gate_bpf, FreeWith<destroy_programs>>;
  explicit Programs(Object object) : object_(std::move(object)) {}
  Object object_;
};

/// Whether a program can be preempted by another one on its CPU.
bool is_preempt_rt();

/// This machine shows the stores of a CPU to others in its order (x86: total store order).
#if defined(__x86_64__) || defined(__i386__)
inline constexpr bool kOrderedStores = true;
#else
inline constexpr bool kOrderedStores = false;
#endif

/// Possible CPUs of this machine: entries of the counters map.
std::uint32_t possible_cpus();

}  // namespace mlcca::enforce
