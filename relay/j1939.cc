// SPDX-License-Identifier: BSD-2-Clause
#include "relay/j1939.hpp"

#include <algorithm>
#include <utility>

namespace mlcca::relay::j1939 {
namespace {

constexpr std::uint32_t kNumber = 0x03ffff00;  // parameter group number, including the destination
                                               // of PDU1
constexpr std::uint32_t kManagement = 0x00ecff00;  // TP.CM to the global address
constexpr std::uint32_t kTransfer = 0x00ebff00;    // TP.DT to the global address
constexpr std::uint32_t kPriority = 0x1c000000;
constexpr unsigned kNumberShift = 8;
constexpr unsigned kOctet = 8;
constexpr std::uint32_t kPgn = 0x3ffff;
constexpr std::uint32_t kGlobalAddress = 0xff;
constexpr std::uint32_t kFirstOfPdu2 = 0xf000;

constexpr std::uint8_t kBam = 32;
constexpr std::uint8_t kFill = 0xff;
constexpr std::size_t kPacket = 7;

/// Whether a parameter group has the format PDU1: the low octet is the destination in an
/// identifier, and 0 in the PGN.
bool has_destination(std::uint32_t pgn) { return (pgn & kFirstOfPdu2) != kFirstOfPdu2; }

std::uint8_t octet_of(std::size_t value, unsigned number) {
  return static_cast<std::uint8_t>(value >> kOctet * number);
}

std::size_t packets_of(std::size_t size) { return (size + kPacket - 1) / kPacket; }

std::size_t size_in(Octets data) { return data[1] | std::size_t{data[2]} << kOctet; }

std::uint8_t source_of(std::uint32_t id) { return static_cast<std::uint8_t>(id & kSource); }

}  // namespace

bool is_announcement(std::uint32_t id) { return (id & kNumber) == kManagement; }
bool is_packet(std::uint32_t id) { return (id & kNumber) == kTransfer; }
std::uint32_t announcement_of(std::uint32_t id) { return (id & ~kNumber) | kManagement; }
std::uint32_t packet_of(std::uint32_t id) { return (id & ~kNumber) | kTransfer; }

std::vector<Data> frames_of(Octets event, std::uint32_t id) {
  std::vector<Data> frames;
  if (event.size() < kLeast || event.size() > kMost) return frames;
  std::uint32_t pgn = id >> kNumberShift & kPgn;
  if (has_destination(pgn)) pgn &= ~kGlobalAddress;
  const std::size_t packets = packets_of(event.size());
  frames.reserve(1 + packets);
  frames.push_back({kBam, octet_of(event.size(), 0), octet_of(event.size(), 1),
                    octet_of(packets, 0), kFill, octet_of(pgn, 0), octet_of(pgn, 1),
                    octet_of(pgn, 2)});
  for (std::size_t i = 0; i < packets; ++i) {
    Data& frame = frames.emplace_back();
    frame.fill(kFill);
    frame[0] = octet_of(i + 1, 0);
    const Octets part = event.subspan(i * kPacket, std::min(kPacket, event.size() - i * kPacket));
    std::ranges::copy(part, frame.begin() + 1);
  }
  return frames;
}

// --- what comes ----------------------------------------------------------------------------------

std::optional<std::uint32_t> Reassembly::announced(std::uint32_t id, Octets data) {
  if (data.size() != Data{}.size() || data[0] != kBam) return std::nullopt;
  const std::uint32_t pgn =
      data[5] | std::uint32_t{data[6]} << kOctet | std::uint32_t{data[7]} << 2 * kOctet;
  if (pgn > kPgn) return std::nullopt;
  const std::uint32_t number = has_destination(pgn) ? pgn | kGlobalAddress : pgn;
  return (id & ~kNumber) | number << kNumberShift;
}

void Reassembly::announce(std::uint32_t id, Octets data, bool wanted, std::uint64_t now) {
  const auto message = announced(id, data);
  if (!message) return;
  if (sessions_.erase(source_of(id)) != 0) ++losses_.incomplete;
  if (!wanted) return;
  const std::size_t size = size_in(data);
  if (size < kLeast || size > kMost || data[3] != packets_of(size)) {
    ++losses_.malformed;
    return;
  }
  Session& session = sessions_[source_of(id)];
  session = {.id = *message, .size = size, .next = 1, .latest_at = now, .begun = {}};
  session.begun.reserve(packets_of(size) * kPacket);
}

std::optional<Reassembly::Message> Reassembly::take(std::uint32_t id, Octets data,
                                                    std::uint64_t now) {
  const auto known = sessions_.find(source_of(id));
  if (known == sessions_.end()) return std::nullopt;
  Session& session = known->second;
  if (data.size() != Data{}.size() || data[0] != session.next ||
      now - session.latest_at > kTimeout) {
    ++losses_.incomplete;
    sessions_.erase(known);
    return std::nullopt;
  }
  session.begun.insert(session.begun.end(), data.begin() + 1, data.end());
  session.latest_at = now;
  ++session.next;
  if (session.begun.size() < session.size) return std::nullopt;
  Message whole{.id = (session.id & ~kPriority) | (id & kPriority),
                .event = std::move(session.begun)};
  whole.event.resize(session.size);
  sessions_.erase(known);
  return whole;
}

void Reassembly::expire(std::uint64_t now) {
  losses_.incomplete += std::erase_if(
      sessions_, [now](const auto& one) { return now - one.second.latest_at > kTimeout; });
}

// --- what goes -----------------------------------------------------------------------------------

bool Sending::add(Message message) {
  Source& source = sources_[source_of(message.announcement)];
  if (message.frames.empty() || source.waiting.size() >= kMostWaiting) return false;
  source.waiting.push_back(std::move(message));
  return true;
}

std::optional<std::uint64_t> Sending::due() const {
  std::optional<std::uint64_t> first;
  for (const auto& [address, source] : sources_)
    if (!source.waiting.empty()) first = std::min(first.value_or(source.due), source.due);
  return first;
}

}  // namespace mlcca::relay::j1939
