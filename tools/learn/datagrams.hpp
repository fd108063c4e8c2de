// SPDX-License-Identifier: BSD-2-Clause
// From UDP datagrams to events of FAMOUSO: of which subject, from whom, how long, also where an
// event has several datagrams. As the gate has it, any datagram to one of FAMOUSO's ports is meant.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "relay/afp.hpp"
#include "tools/learn/decode.hpp"
#include "tools/learn/recognise.hpp"

namespace mlcca::learn {

class Datagrams {
 public:
  /// Ports whose traffic is counted apart.
  static constexpr std::size_t kMostPorts = 256;

  /// Of a frame with a datagram. Calls `on_event` when the last fragment of an event has come. The
  /// node of an event is the address of its sender; 0 of a local one, whatever address it takes.
  void take(const Frame& frame, const Decoder::OnEvent& on_event);

  /// Whether these are FAMOUSO's; otherwise the profile is none.
  [[nodiscard]] Recognised recognised() const;
  /// Events of the subjects by which FAMOUSO manages itself, which need no channel.
  [[nodiscard]] std::uint64_t control() const { return control_; }
  /// Of these the ones that only some configurations have, and that no gate knows.
  [[nodiscard]] std::uint64_t management() const { return management_; }
  /// Datagrams to FAMOUSO's ports that are no events, or from an address that no station has.
  [[nodiscard]] std::uint64_t malformed() const { return malformed_; }
  /// Datagrams of events that were not complete: a fragment was missing, or too many were begun.
  [[nodiscard]] std::uint64_t incomplete() const;
  /// Datagrams to other ports, and of which: "port 5353 (12), port 123 (4), others (1)".
  [[nodiscard]] std::uint64_t others() const { return others_; }
  [[nodiscard]] std::string other_ports() const;

 private:
  void take_fragment(const Frame& frame, Event event, std::span<const std::uint8_t> data,
                     const Decoder::OnEvent& on_event);
  void count_other(const Datagram& datagram);

  static constexpr relay::afp::Reassembly::Limits kLimits{.begun = 64, .octets = 1U << 19U};
  relay::afp::Reassembly fragments_{relay::afp::kUdp, kLimits};
  std::uint64_t now_ = 0;               ///< the latest time that was seen
  std::vector<std::uint8_t> fragment_;  ///< with zeros in the place of what was cut off
  bool is_cut_ = false;                 ///< the beginning of an event may be such zeros
  std::uint64_t events_ = 0;            ///< well-formed datagrams, those of control among them
  std::uint64_t grouped_ = 0;           ///< of these, to the group of their subject
  std::uint64_t control_ = 0;
  std::uint64_t management_ = 0;
  std::uint64_t malformed_ = 0;
  std::uint64_t others_ = 0;
  std::map<std::uint16_t, std::uint64_t> ports_;
};

}  // namespace mlcca::learn
