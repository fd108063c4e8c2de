// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/local_protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/big_endian.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint8_t kSubscribe = 0x50;
constexpr std::uint8_t kPublish = 0x52;
constexpr std::uint8_t kAnnounce = 0x56;
constexpr std::size_t kSubject = 8;
constexpr std::size_t kOpening = 1 + kSubject;
constexpr std::size_t kHead = kOpening + 4;  // octets in front of the data of an event

void put(std::uint64_t number, std::size_t octets, std::vector<std::uint8_t>& to) {
  while (octets-- > 0) to.push_back(static_cast<std::uint8_t>(number >> 8U * octets));
}

}  // namespace

void LocalSession::end(std::string why) {
  role_ = Role::ended;
  why_ = std::move(why);
  in_.clear();
}

void LocalSession::take(Octets octets, std::vector<Event>& events) {
  // The input is taken in pieces, so that at most one message is stored, however many octets
  // arrive.
  while (!octets.empty() && role_ != Role::ended) {
    const std::size_t piece = std::min(octets.size(), kHead + kMostOctets - in_.size());
    in_.insert(in_.end(), octets.begin(), octets.begin() + static_cast<std::ptrdiff_t>(piece));
    octets = octets.subspan(piece);
    if (role_ == Role::unknown && !take_opening()) continue;
    if (role_ == Role::subscriber && !in_.empty()) end("the subscriber has said something");
    while (role_ == Role::publisher && take_event(events)) {
    }
  }
}

std::size_t LocalSession::missing() const {
  return role_ == Role::unknown ? kOpening - in_.size() : 0;
}

bool LocalSession::take_opening() {
  if (in_.size() < kOpening) return false;
  subject_ = from_big_endian(Octets(in_).subspan(1, kSubject));
  if (in_[0] == kSubscribe)
    role_ = Role::subscriber;
  else if (in_[0] == kAnnounce)
    role_ = Role::publisher;
  else
    end("the first octet is neither 0x50 (subscribe) nor 0x56 (announce)");
  if (role_ != Role::ended) in_.erase(in_.begin(), in_.begin() + kOpening);
  return true;
}

/// Moves one event from the input to `events`. Returns false if none is complete.
bool LocalSession::take_event(std::vector<Event>& events) {
  if (in_.empty()) return false;
  if (in_[0] != kPublish) {
    end("the publisher has sent what is no event");
    return false;
  }
  if (in_.size() < kHead) return false;
  if (const std::uint64_t subject = from_big_endian(Octets(in_).subspan(1, kSubject));
      subject != subject_) {
    end(fmt::format("an event of 0x{:016x}: 0x{:016x} is announced", subject, subject_));
    return false;
  }
  const std::uint64_t length = from_big_endian(Octets(in_).subspan(kOpening, kHead - kOpening));
  if (length > kMostOctets) {
    end("an event of " + std::to_string(length) + " octets: at most " +
        std::to_string(kMostOctets) + " are possible");
    return false;
  }
  const std::size_t whole = kHead + static_cast<std::size_t>(length);
  if (in_.size() < whole) return false;
  const auto end_of_event = in_.begin() + static_cast<std::ptrdiff_t>(whole);
  events.emplace_back(in_.begin() + kHead, end_of_event);
  in_.erase(in_.begin(), end_of_event);
  return true;
}

bool LocalSession::send(Octets event) {
  if (role_ != Role::subscriber || event.size() > kMostOctets ||
      waiting().size() + kHead + event.size() > kMostWaiting) {
    ++lost_;
    return false;
  }
  out_.push_back(kPublish);
  put(subject_, kSubject, out_);
  put(event.size(), kHead - kOpening, out_);
  out_.insert(out_.end(), event.begin(), event.end());
  return true;
}

void LocalSession::written(std::size_t octets) {
  written_ += octets;
  if (written_ < out_.size() && written_ < kMostWaiting) return;
  out_.erase(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(written_));
  written_ = 0;
}

}  // namespace mlcca::relay
