// SPDX-License-Identifier: BSD-2-Clause
// Selects datagrams and IEEE 802.15.4 frames that prove the content of a gate, with their expected
// fate. No I/O.
#pragma once
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "daemon/gates/readback.hpp"

namespace mlcca::readback {

/// An event in one frame: a UDP datagram, an AWDS packet if its station has a MAC address, or an
/// IEEE 802.15.4 frame if the station belongs to that.
struct EtherProbe {
  bool out = false;  ///< sent by a program on this machine; otherwise it arrives from the wire
  std::uint64_t subject = 0;
  std::uint16_t payload = 0;  ///< bytes
  std::uint32_t uid = 0;      ///< of the program that sends it
  std::uint64_t station = 0;  ///< the sender, as ether_station() encodes it

  auto operator<=>(const EtherProbe&) const = default;
};

/// The probes for one gate.
class EtherProbes {
 public:
  /// At most so many slots are tried; if there are more, every n-th.
  static constexpr std::size_t kMost = 4096;

  explicit EtherProbes(const gates::GateReading& gate);

  /// For every slot a datagram that fits, one that is too long and one from a station without a
  /// slot; also one with a subject that has no slot.
  [[nodiscard]] const std::vector<EtherProbe>& probes() const { return probes_; }
  /// Why further slots cannot be tried, one line each.
  [[nodiscard]] const std::vector<std::string>& untried() const { return untried_; }
  /// Whether the gate should pass the probe while it is open.
  [[nodiscard]] bool is_admitted(const EtherProbe& probe) const;

 private:
  void add(const gates::SlotSpec& slot);
  [[nodiscard]] std::uint64_t station_without_slot(std::uint64_t subject) const;

  std::unordered_multimap<std::uint64_t, const gates::SlotSpec*> slots_;  ///< by subject
  std::uint64_t first_station_;  ///< the first of the station numbers that are used for stations
                                 ///< without a slot
  std::vector<EtherProbe> probes_;
  std::vector<std::string> untried_;
};

std::string to_text(const EtherProbe& probe);

/// The EtherType by which the kernel dispatches the frame on an Ethernet device.
[[nodiscard]] std::uint16_t ethertype_of(const EtherProbe& probe);

/// The bytes: an Ethernet frame with headers of IPv4 and UDP or of AWDS, or a MAC frame of
/// 802.15.4.
std::vector<std::uint8_t> frame_of(const EtherProbe& probe);

}  // namespace mlcca::readback
