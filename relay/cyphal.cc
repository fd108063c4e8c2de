// SPDX-License-Identifier: BSD-2-Clause
#include "relay/cyphal.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "relay/fd_length.hpp"

namespace mlcca::relay::cyphal {
namespace {

constexpr std::uint8_t kFirst = 0x80;
constexpr std::uint8_t kLast = 0x40;
constexpr std::uint8_t kToggle = 0x20;
constexpr std::size_t kTail = 1;
constexpr std::size_t kCrc = 2;
constexpr std::size_t kShort = 8;  // up to this length, frames of every length exist

constexpr std::array<std::uint16_t, 256> table() {
  std::array<std::uint16_t, 256> out{};
  for (unsigned octet = 0; octet < out.size(); ++octet) {
    unsigned rest = octet << 8U;
    for (int bit = 0; bit < 8; ++bit)
      rest = (rest & 0x8000U) != 0 ? rest << 1U ^ 0x1021U : rest << 1U;
    out.at(octet) = static_cast<std::uint16_t>(rest);
  }
  return out;
}

/// Octets to append so that a frame of this content and a tail octet has a valid length.
std::size_t padding(std::size_t content) {
  if (content + kTail <= kShort) return 0;
  return fd_length(content + kTail).value_or(content + kTail) - content - kTail;
}

Event with_tail(Octets content, std::uint8_t tail) {
  Event frame(content.begin(), content.end());
  frame.push_back(tail);
  return frame;
}

}  // namespace

std::uint16_t crc(Octets octets, std::uint16_t begun) {
  static constexpr auto sums = table();
  for (const std::uint8_t octet : octets)
    begun = static_cast<std::uint16_t>(begun << 8U ^ sums.at((begun >> 8U ^ octet) & 0xffU));
  return begun;
}

// --- frames of an event --------------------------------------------------------------------------

Result<std::vector<Event>> frames_of(Octets event, std::size_t frame_octets, std::uint8_t number) {
  if (frame_octets < kTail || (frame_octets < kShort && event.size() + kTail > frame_octets))
    return fail("frames of " + std::to_string(frame_octets) + " octets carry no event of " +
                std::to_string(event.size()));
  const std::size_t chunk = frame_octets - kTail;
  number &= kNumbers;
  if (event.size() <= chunk) {
    Event content(event.begin(), event.end());
    content.resize(content.size() + padding(content.size()));
    return std::vector<Event>{with_tail(content, kFirst | kLast | kToggle | number)};
  }
  Event all(event.begin(), event.end());
  const std::size_t last = (all.size() + kCrc - 1) % chunk + 1;
  all.resize(all.size() + padding(last));
  const std::uint16_t sum = crc(all);
  all.push_back(static_cast<std::uint8_t>(sum >> 8U));
  all.push_back(static_cast<std::uint8_t>(sum));
  const std::size_t count = (all.size() + chunk - 1) / chunk;
  if (count > kMostFrames)
    return fail("the event needs " + std::to_string(count) + " frames, more than " +
                std::to_string(kMostFrames));
  std::vector<Event> frames;
  frames.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Octets content = Octets(all).subspan(i * chunk, std::min(chunk, all.size() - i * chunk));
    const unsigned tail = (i == 0 ? kFirst : 0U) | (i + 1 == count ? kLast : 0U) |
                          (i % 2 == 0 ? kToggle : 0U) | number;
    frames.push_back(with_tail(content, static_cast<std::uint8_t>(tail)));
  }
  return frames;
}

// --- events of frames ----------------------------------------------------------------------------

Reassembly::Session& Reassembly::session_of(Source source, std::uint64_t now) {
  auto known = sessions_.find(source);
  if (known == sessions_.end()) {
    if (sessions_.size() >= limits_.sources) {
      const auto silent = std::ranges::min_element(
          sessions_, {}, [](const auto& entry) { return entry.second.latest_at; });
      give_up(silent->second, losses_.crowded);
      sessions_.erase(silent);
    }
    known = sessions_.emplace(source, Session{}).first;
  }
  Session& session = known->second;
  if (session.is_begun && now - session.latest_at > limits_.lifetime_ns)
    give_up(session, losses_.incomplete);
  session.latest_at = now;
  return session;
}

void Reassembly::give_up(Session& session, std::uint64_t& why) {
  if (!std::exchange(session.is_begun, false)) return;
  ++why;
  octets_ -= session.begun.size();
  Event().swap(session.begun);
}

/// Whether a complete transfer with this transfer-ID was received a short time ago: when a sender
/// misses the acknowledgement of a frame, it repeats the frame and with it the transfer.
bool Reassembly::is_repeated(const Session& session, std::uint8_t number, std::uint64_t now) const {
  return session.latest == number && now - session.completed_at <= limits_.lifetime_ns;
}

/// Frees memory: the source that was silent for longest loses its incomplete transfer. Returns
/// false if no other source has one.
bool Reassembly::make_room(std::size_t octets, const Session& beside) {
  while (octets_ + octets > limits_.octets) {
    Session* victim = nullptr;
    for (auto& [source, session] : sessions_)
      if (session.is_begun && &session != &beside &&
          (victim == nullptr || session.latest_at < victim->latest_at))
        victim = &session;
    if (victim == nullptr) return false;
    give_up(*victim, losses_.crowded);
  }
  return true;
}

std::optional<Event> Reassembly::take(Source source, Octets frame, std::uint64_t now) {
  const std::uint8_t tail = frame.empty() ? 0 : frame.back();
  const bool first = (tail & kFirst) != 0;
  const bool last = (tail & kLast) != 0;
  const bool toggle = (tail & kToggle) != 0;
  const std::uint8_t number = tail & kNumbers;
  // A first frame without toggle bit belongs to UAVCAN 0. A frame that others follow must be full.
  if (frame.empty() || (first && !toggle) || (!last && frame.size() < kShort)) {
    ++losses_.malformed;
    return std::nullopt;
  }
  Session& session = session_of(source, now);
  const bool goes_on = !first && session.is_begun && session.number == number;
  if (!goes_on && is_repeated(session, number, now)) {
    if (last) ++losses_.duplicates;
    return std::nullopt;
  }
  const Octets content = frame.first(frame.size() - kTail);
  if (first) {
    if (session.is_begun && session.number == number && std::ranges::equal(session.begun, content))
      return std::nullopt;  // a duplicate of the first frame
    give_up(session, losses_.incomplete);
    session.is_begun = true;
    session.toggle = true;
    session.number = number;
  } else if (!goes_on) {
    if (last) ++losses_.incomplete;
    return std::nullopt;
  }
  if (toggle != session.toggle) return std::nullopt;  // a duplicate of the previous frame
  session.toggle = !toggle;
  if (!first || !last) return take_rest(session, content, last, now);
  session.is_begun = false;
  session.latest = number;
  session.completed_at = now;
  return Event(content.begin(), content.end());
}

std::optional<Event> Reassembly::take_rest(Session& session, Octets content, bool last,
                                           std::uint64_t now) {
  if (!make_room(content.size(), session)) {
    give_up(session, losses_.crowded);
    return std::nullopt;
  }
  session.begun.insert(session.begun.end(), content.begin(), content.end());
  octets_ += content.size();
  if (!last) return std::nullopt;
  if (session.begun.size() < kCrc || crc(session.begun) != 0) {
    give_up(session, losses_.incomplete);
    return std::nullopt;
  }
  octets_ -= session.begun.size();
  session.is_begun = false;
  session.latest = session.number;
  session.completed_at = now;
  Event event = std::exchange(session.begun, {});
  event.resize(event.size() - kCrc);
  return event;
}

void Reassembly::expire(std::uint64_t now) {
  for (auto& [source, session] : sessions_)
    if (session.is_begun && now - session.latest_at > limits_.lifetime_ns)
      give_up(session, losses_.incomplete);
}

}  // namespace mlcca::relay::cyphal
