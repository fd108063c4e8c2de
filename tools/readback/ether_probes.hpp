// SPDX-License-Identifier: BSD-2-Clause
// Which datagrams or frames of IEEE 802.15.4 prove what a gate holds, and what must become of them.
// Pure.
#pragma once
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "daemon/gates/readback.hpp"

namespace mlcca::readback {

/// An event in one UDP datagram, in one AWDS packet where its station has a MAC address, or in one
/// frame of IEEE 802.15.4 where it is a station of that.
struct EtherProbe {
  bool out = false;  ///< sent by a program on this machine; else from the wire
  std::uint64_t subject = 0;
  std::uint16_t payload = 0;  ///< bytes
  std::uint32_t uid = 0;      ///< of the program
  std::uint64_t station = 0;  ///< whom it is from, as ether_station()

  auto operator<=>(const EtherProbe&) const = default;
};

class EtherProbes {
 public:
  /// Slots that are tried, at most; of more slots every n-th.
  static constexpr std::size_t kMost = 4096;

  explicit EtherProbes(const enforce::GateReading& gate);

  /// For every slot a datagram that fits it, one that is longer, and one from a station without a
  /// slot; and a subject without a slot.
  [[nodiscard]] const std::vector<EtherProbe>& probes() const { return probes_; }
  /// Why others are out of reach, one line each.
  [[nodiscard]] const std::vector<std::string>& untried() const { return untried_; }
  /// What the gate lets pass while it is open.
  [[nodiscard]] bool is_admitted(const EtherProbe& probe) const;

 private:
  void add(const enforce::SlotSpec& slot);
  [[nodiscard]] std::uint64_t station_without_slot(std::uint64_t subject) const;

  std::unordered_multimap<std::uint64_t, const enforce::SlotSpec*> slots_;  ///< by subject
  std::uint64_t first_station_;  ///< of those that probes are made up from
  std::vector<EtherProbe> probes_;
  std::vector<std::string> untried_;
};

std::string to_text(const EtherProbe& probe);

/// By which the kernel sorts its frame on an Ethernet device, whatever it is.
[[nodiscard]] std::uint16_t ethertype_of(const EtherProbe& probe);

/// The Ethernet frame, with the headers of IPv4 and UDP or of AWDS; or the MAC frame of 802.15.4.
std::vector<std::uint8_t> frame_of(const EtherProbe& probe);

}  // namespace mlcca::readback
