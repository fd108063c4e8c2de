// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/ether_probes.hpp"

#include <fmt/format.h>
#include <linux/if_ether.h>

#include <algorithm>

#include "base/many.hpp"
#include "bpf/ether.h"
#include "core/model/station.hpp"
#include "core/model/text.hpp"

namespace mlcca::readback {
namespace {

/// Larger datagrams would be divided into IP fragments.
constexpr std::uint16_t kMostPayload = 1400;
/// 192.0.2.1; if it is a station of the table, the next address is used (RFC 5737: these belong to
/// no host).
constexpr std::uint64_t kStation = 0xc0000201;
/// For 802.15.4: short addresses of an invented PAN.
constexpr std::uint64_t kPan = 0x6d6c;
constexpr std::uint64_t kWpanStation = ETHER_SHORT | kPan << 16U | 1;

bool is_wpan(const EtherProbe& probe) { return core::Station{probe.station}.is_wpan(); }

void put(std::vector<std::uint8_t>& to, std::uint64_t number, unsigned octets) {
  while (octets-- > 0) to.push_back(static_cast<std::uint8_t>(number >> (8 * octets)));
}

}  // namespace

EtherProbes::EtherProbes(const gates::GateReading& gate)
    : first_station_(gate.wpan ? kWpanStation : kStation) {
  std::size_t forwarded = 0;
  std::vector<const gates::SlotSpec*> within_reach;
  for (const gates::SlotSpec& slot : gate.slots) {
    slots_.emplace(slot.subject, &slot);
    const bool out = slot.direction == gates::Direction::egress;
    if ((out && slot.source != 0) || (slot.formats & ETHER_UNFRAGMENTED) == 0)
      ++forwarded;
    else
      within_reach.push_back(&slot);
  }
  const std::size_t step = (within_reach.size() + kMost - 1) / kMost;
  for (std::size_t i = 0; i < within_reach.size(); i += step) add(*within_reach[i]);
  std::uint64_t unknown = 0x6d6c636361000000;
  while (slots_.contains(unknown)) ++unknown;
  for (const bool out : {false, true})
    probes_.push_back({.out = out, .subject = unknown, .station = first_station_});
  std::ranges::sort(probes_);
  const auto same = std::ranges::unique(probes_);
  probes_.erase(same.begin(), same.end());
  if (forwarded != 0)
    untried_.push_back(many(forwarded, "slot") +
                       " for what comes by another interface or only in fragments");
  if (step > 1)
    untried_.push_back(
        fmt::format("{} of {}: every {}th was",
                    many(within_reach.size() - (within_reach.size() + step - 1) / step, "slot"),
                    within_reach.size(), step));
}

void EtherProbes::add(const gates::SlotSpec& slot) {
  EtherProbe probe{
      .out = slot.direction == gates::Direction::egress,
      .subject = slot.subject,
      .payload = std::min(slot.max_len, kMostPayload),
      .station = slot.station != 0 ? slot.station : station_without_slot(slot.subject)};
  if (probe.out && slot.uid != GATE_ANY_UID) probe.uid = slot.uid;
  probes_.push_back(probe);
  if (slot.station != 0) {
    EtherProbe from_another = probe;
    from_another.station = station_without_slot(slot.subject);
    probes_.push_back(from_another);
  }
  if (slot.max_len >= kMostPayload) return;
  ++probe.payload;
  probes_.push_back(probe);
}

std::uint64_t EtherProbes::station_without_slot(std::uint64_t subject) const {
  const auto [first, last] = slots_.equal_range(subject);
  std::uint64_t station = first_station_;
  while (
      std::any_of(first, last, [&](const auto& known) { return known.second->station == station; }))
    ++station;
  return station;
}

bool EtherProbes::is_admitted(const EtherProbe& probe) const {
  const auto [first, last] = slots_.equal_range(probe.subject);
  const auto may_send = [&](const gates::SlotSpec& slot) {
    return (slot.direction == gates::Direction::egress) == probe.out &&
           (!probe.out ||
            (slot.source == 0 && (slot.uid == GATE_ANY_UID || slot.uid == probe.uid)));
  };
  // The wildcard entry does not apply to a station that has an entry of its own.
  const bool known = std::any_of(first, last, [&](const auto& at) {
    return may_send(*at.second) && at.second->station == probe.station;
  });
  return std::any_of(first, last, [&](const auto& at) {
    const gates::SlotSpec& slot = *at.second;
    return may_send(slot) && slot.station == (known ? probe.station : 0) && slot.pass &&
           (slot.formats & ETHER_UNFRAGMENTED) != 0 && probe.payload <= slot.max_len;
  });
}

std::string to_text(const EtherProbe& probe) {
  return fmt::format("{} of {} {}", core::format_subject(probe.subject),
                     many(probe.payload, "byte"),
                     probe.out ? fmt::format("sent by user {}", probe.uid)
                               : "from " + core::to_text(core::Station{probe.station}));
}

std::uint16_t ethertype_of(const EtherProbe& probe) {
  if (!is_wpan(probe)) return (probe.station & ETHER_MAC) != 0 ? ETHER_P_AWDS : ETH_P_IP;
  constexpr std::size_t type_at = std::size_t{2} * ETH_ALEN;
  const auto frame = frame_of(probe);
  const auto type = static_cast<std::uint16_t>(frame[type_at] << 8 | frame[type_at + 1]);
  return type < ETH_P_802_3_MIN ? ETH_P_802_2 : type;
}

namespace {

void put_little(std::vector<std::uint8_t>& to, std::uint64_t number, unsigned octets) {
  for (; octets-- > 0; number >>= 8) to.push_back(static_cast<std::uint8_t>(number));
}

/// A data frame to all nodes of a PAN.
std::vector<std::uint8_t> wpan_frame(const EtherProbe& probe) {
  constexpr std::uint64_t to_all = 0x0841;  // frame control: data, one PAN, short destination
                                            // address
  constexpr unsigned from = 14;  // position of the source address mode: 2 short, 3 extended
  const bool extended = (probe.station & ETHER_EXTENDED) != 0;
  std::vector<std::uint8_t> frame;
  put_little(frame, to_all | (extended ? 3U : 2U) << from, 2);
  put_little(frame, 0, 1);  // sequence number
  put_little(frame, extended ? kPan : probe.station >> 16U, 2);
  put_little(frame, 0xffff, 2);
  put_little(frame, extended ? probe.station & ~ETHER_EXTENDED : probe.station, extended ? 8 : 2);
  put(frame, probe.subject, sizeof(probe.subject));
  return frame;
}

/// An Ethernet header to a multicast address, from an invented station.
std::vector<std::uint8_t> link_header(const EtherProbe& probe) {
  std::vector<std::uint8_t> frame{0x01, 0x00, 0x5e, 0x4d, 0x4c, 0x43, 0x02, 0, 0, 0, 0, 0x01};
  put(frame, ethertype_of(probe), 2);
  return frame;
}

/// A flood packet of the mesh that contains an event.
std::vector<std::uint8_t> awds_packet(const EtherProbe& probe) {
  auto frame = link_header(probe);
  put(frame, ETHER_AWDS_FLOOD, 1);
  put(frame, probe.station, 6);
  put(frame, 0, 2);              // sequence number
  put(frame, probe.station, 6);  // last hop
  put(frame, 1, 1);              // TTL
  put(frame, ETHER_AWDS_PUBLISH, 1);
  put(frame, 0, 1);
  put(frame, sizeof(probe.subject) + probe.payload, 2);
  put(frame, probe.subject, sizeof(probe.subject));
  return frame;
}

/// A UDP datagram to 239.77.76.67.
std::vector<std::uint8_t> datagram(const EtherProbe& probe) {
  constexpr unsigned ip_header = 20;
  const unsigned udp = ETHER_UDP_HEADER + ETHER_EVENT_HEADER + probe.payload;
  auto frame = link_header(probe);
  put(frame, 0x4500, 2);
  put(frame, ip_header + udp, 2);
  put(frame, 0x00004000, 4);  // do not fragment
  put(frame, 0x0111, 2);      // TTL 1, UDP
  put(frame, 0, 2);           // without a checksum, which no program here checks
  put(frame, probe.station, 4);
  put(frame, 0xef4d4c43, 4);
  put(frame, ETHER_MULTICAST_PORT, 2);
  put(frame, ETHER_MULTICAST_PORT, 2);
  put(frame, udp, 2);
  put(frame, 0, 2);
  put(frame, probe.subject, 8);
  put(frame, 0, 1);
  return frame;
}

std::vector<std::uint8_t> headers_of(const EtherProbe& probe) {
  if (is_wpan(probe)) return wpan_frame(probe);
  return ethertype_of(probe) == ETHER_P_AWDS ? awds_packet(probe) : datagram(probe);
}

}  // namespace

std::vector<std::uint8_t> frame_of(const EtherProbe& probe) {
  auto frame = headers_of(probe);
  frame.resize(frame.size() + probe.payload);
  return frame;
}

}  // namespace mlcca::readback
