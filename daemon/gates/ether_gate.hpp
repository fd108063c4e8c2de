// SPDX-License-Identifier: BSD-2-Clause
// The gate of one interface whose frames carry the subject: Ethernet-like ones, and those of IEEE
// 802.15.4.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/port_gate.hpp"

namespace mlcca::enforce {

/// What the frames of an interface begin with.
enum class Framing : std::uint8_t { other, ethernet, wpan /**< MAC frames of IEEE 802.15.4 */ };

struct EtherConfig {
  std::uint32_t ifindex = 0;
  std::string name;                               ///< for error texts
  std::size_t slots = 0;                          ///< so many there must be room for
  std::optional<Hook> hook;                       ///< the best one that the kernel has
  bool silent = false;                            ///< as GateConfig::silent
  std::optional<Framing> framing = std::nullopt;  ///< of a copy; none: that of the interface
};

class EtherGate final : public PortGate {
 public:
  /// Loads a gate and puts it in place. Where the driver has XDP and no other program is
  /// there, what is refused is dropped there. Error: an interface of another framing.
  static Result<EtherGate> attach(const EtherConfig& config, const Control& control);
  /// See PortGate::load().
  static Result<EtherGate> load(const EtherConfig& config, const Control& control);

  /// It is as `config` wants it, and there is room for so many slots.
  [[nodiscard]] bool holds(const EtherConfig& config) const;

 private:
  EtherGate(PortGate loaded, bool silent);
  bool silent_;
};

/// Of an interface; an error where the kernel does not say.
Result<Framing> framing_of(std::uint32_t ifindex);

}  // namespace mlcca::enforce
