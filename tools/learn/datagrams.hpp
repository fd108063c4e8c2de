// SPDX-License-Identifier: BSD-2-Clause
// Extracts events of FAMOUSO from UDP datagrams: subject, sender and size, also of events in
// several datagrams. As in the gate, every datagram to one of FAMOUSO's ports is considered.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "relay/afp.hpp"
#include "tools/learn/decode.hpp"
#include "tools/learn/recognise.hpp"

namespace mlcca::learn {

/// How many datagrams with events went to each of FAMOUSO's ports. A subscriber listens at one of
/// them, by the kind of its network.
struct Transports {
  std::uint64_t multicast = 0;  ///< port 9999
  std::uint64_t broadcast = 0;  ///< port 8888
  [[nodiscard]] std::uint64_t all() const { return multicast + broadcast; }
  /// The kind by which most of them are received; udp-multicast if there are none.
  [[nodiscard]] core::NetworkKind most() const {
    return broadcast > multicast ? core::NetworkKind::udp_broadcast
                                 : core::NetworkKind::udp_multicast;
  }
  /// Those that subscribers of a network of this kind do not receive.
  [[nodiscard]] std::uint64_t missed_by(core::NetworkKind kind) const {
    return kind == core::NetworkKind::udp_broadcast ? multicast : broadcast;
  }
};
/// "udp-broadcast (port 8888)", or of the other one.
[[nodiscard]] std::string transport_word(bool is_broadcast);

/// Decodes the datagrams of one interface.
class Datagrams {
 public:
  /// At most so many ports are counted separately.
  static constexpr std::size_t kMostPorts = 256;
  /// At most so many senders of what is no event are counted separately.
  static constexpr std::size_t kMostSenders = 64;

  /// Takes a frame with a datagram. Calls `on_event` when the last fragment of an event has
  /// arrived. The node of an event is the address of its sender; it is 0 for a local sender,
  /// whatever its address.
  void take(const Frame& frame, const Decoder::OnEvent& on_event);

  [[nodiscard]] const Transports& transports() const { return transports_; }
  /// Whether the datagrams are FAMOUSO's; if not, the profile is none.
  [[nodiscard]] Recognised recognised() const;
  /// The number of events of subjects for FAMOUSO's own control, which need no channel.
  [[nodiscard]] std::uint64_t control() const { return control_; }
  /// How many of them are of the management layer, which only some configurations have and which no
  /// gate knows.
  [[nodiscard]] std::uint64_t management() const { return management_; }
  /// The number of datagrams to FAMOUSO's ports that are not events, or are from an invalid
  /// address.
  [[nodiscard]] std::uint64_t malformed() const { return malformed_; }
  /// Who sent them, those with most first: "5 from 192.0.2.9, 3 from others".
  [[nodiscard]] std::string malformed_senders() const;
  /// The number of datagrams of incomplete events: a fragment was missing, or too many events had
  /// begun.
  [[nodiscard]] std::uint64_t incomplete() const;
  /// The number of datagrams to other ports, and a list such as "port 5353 (12), port 123 (4),
  /// others (1)".
  [[nodiscard]] std::uint64_t others() const { return others_; }
  [[nodiscard]] std::string other_ports() const;
  /// What needs no channel or is no event, in words; `name` is that of the interface.
  [[nodiscard]] std::vector<std::string> notes(const std::string& name) const;

 private:
  /// Adds a fragment to its event. `data` is what was recorded of it.
  void take_fragment(const Frame& frame, Event event, std::span<const std::uint8_t> data,
                     const Decoder::OnEvent& on_event);
  void count_other(const Datagram& datagram);
  void count_malformed(const Frame& frame);

  static constexpr relay::afp::Reassembly::Limits kLimits{.begun = 64, .octets = 1U << 19U};
  relay::afp::Reassembly fragments_{relay::afp::kUdp, kLimits};
  std::uint64_t now_ = 0;               ///< the latest time of a frame
  std::vector<std::uint8_t> fragment_;  ///< the fragment with zeros in place of bytes that were not
                                        ///< recorded
  bool is_cut_ = false;                 ///< the beginning of an event may consist of such zeros
  std::uint64_t events_ = 0;            ///< well-formed datagrams, including those of control
  Transports transports_;               ///< of them
  std::uint64_t grouped_ = 0;  ///< those of them that went to the multicast group of their subject
  std::uint64_t control_ = 0;
  std::uint64_t management_ = 0;
  std::uint64_t malformed_ = 0;
  std::uint64_t others_ = 0;
  std::map<std::uint16_t, std::uint64_t> ports_;
  std::map<std::string, std::uint64_t> malformed_from_;
};

}  // namespace mlcca::learn
