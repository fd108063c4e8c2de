// SPDX-License-Identifier: BSD-2-Clause
// The gate of an interface whose frames carry the subject: Ethernet-like ones, and those of IEEE
// 802.15.4.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/port_gate.hpp"

namespace mlcca::gates {

/// The header that the frames of an interface begin with.
enum class Framing : std::uint8_t { other, ethernet, wpan /**< MAC frames of IEEE 802.15.4 */ };

/// What the gate of an interface must be.
struct EtherConfig {
  std::uint32_t ifindex = 0;
  std::string name;                               ///< for error texts
  std::size_t slots = 0;                          ///< there must be room for this many
  std::optional<Hook> hook;                       ///< nullopt: the best one that the kernel has
  bool silent = false;                            ///< as GateConfig::silent
  std::optional<Framing> framing = std::nullopt;  ///< of a copy; nullopt: that of the interface
};

/// See PortGate. Where the driver supports XDP and has no other program, refused frames are dropped
/// there.
class EtherGate final : public PortGate {
 public:
  /// Loads a gate and puts it in place. The error: among others, an interface with another framing.
  static Result<EtherGate> attach(const EtherConfig& config, const Control& control);
  /// See PortGate::load().
  static Result<EtherGate> load(const EtherConfig& config, const Control& control);

  /// Whether the gate is as `config` wants it, with room for its slots.
  [[nodiscard]] bool holds(const EtherConfig& config) const;

 private:
  EtherGate(PortGate loaded, bool silent);
  bool silent_;
};

/// The framing of an interface; an error if the kernel does not state it.
Result<Framing> framing_of(std::uint32_t ifindex);

}  // namespace mlcca::gates
