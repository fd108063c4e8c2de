// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/turns.hpp"

#include <algorithm>
#include <iterator>

namespace mlcca::serve {

// --- the rate of one user ------------------------------------------------------------------------

void Bucket::fill(std::uint64_t now) {
  if (now <= filled_) return;
  const std::uint64_t most = rate_.burst * kSecond;
  // No more time counts than the bucket needs to fill up, so that the product cannot overflow.
  const std::uint64_t whole = rate_.per_second == 0 ? ~0ULL : most / rate_.per_second + 1;
  const std::uint64_t passed = std::min(now - filled_, whole);
  left_ = std::min(most, left_ + passed * rate_.per_second);
  filled_ = now;
}

bool Bucket::take(std::uint64_t now) {
  fill(now);
  if (left_ < kSecond) return false;
  left_ -= kSecond;
  return true;
}

std::uint64_t Bucket::ready_at(std::uint64_t now) {
  fill(now);
  if (left_ >= kSecond) return now;
  if (rate_.per_second == 0) return ~0ULL;
  return now + (kSecond - left_ + rate_.per_second - 1) / rate_.per_second;
}

bool Bucket::full(std::uint64_t now) {
  fill(now);
  return left_ == rate_.burst * kSecond;
}

// --- the ring ------------------------------------------------------------------------------------

Turns::Line& Turns::line_of(User user, std::uint64_t now) {
  const auto known = users_.find(user);
  if (known != users_.end()) return known->second;
  return users_.emplace(user, Line{Bucket(user.member ? members_ : others_, now), {}})
      .first->second;
}

void Turns::add(User user, Id session) {
  Line& line = line_of(user, 0);
  if (line.sessions.empty()) (user.member ? members_ring_ : others_ring_).push_back(user);
  line.sessions.push_back(session);
}

void Turns::remove(User user, Id session) {
  const auto known = users_.find(user);
  if (known == users_.end()) return;
  auto& sessions = known->second.sessions;
  if (std::erase(sessions, session) != 0 && sessions.empty())
    std::erase(user.member ? members_ring_ : others_ring_, user);
}

std::optional<Turns::Id> Turns::next_of(std::deque<User>& ring, std::uint64_t now) {
  for (std::size_t tried = ring.size(); tried > 0; --tried) {
    const User user = ring.front();
    ring.pop_front();
    Line& line = users_.at(user);
    if (!line.bucket.take(now)) {
      ring.push_back(user);
      continue;
    }
    const Id session = line.sessions.front();
    line.sessions.pop_front();
    if (!line.sessions.empty()) ring.push_back(user);
    return session;
  }
  return std::nullopt;
}

std::optional<Turns::Id> Turns::next(std::uint64_t now) {
  members_turn_ = !members_turn_;
  auto& first = members_turn_ ? members_ring_ : others_ring_;
  auto& second = members_turn_ ? others_ring_ : members_ring_;
  if (const auto session = next_of(first, now)) return session;
  return next_of(second, now);
}

bool Turns::step(User user, std::uint64_t now) { return line_of(user, now).bucket.take(now); }

std::optional<std::uint64_t> Turns::next_ready(std::uint64_t now) {
  std::optional<std::uint64_t> first;
  for (const auto* ring : {&members_ring_, &others_ring_})
    for (const User user : *ring) {
      const std::uint64_t at = users_.at(user).bucket.ready_at(now);
      first = first ? std::min(*first, at) : at;
    }
  return first;
}

void Turns::tidy(std::uint64_t now) {
  for (auto user = users_.begin(); user != users_.end();) {
    const bool unused = user->second.sessions.empty() && user->second.bucket.full(now);
    user = unused ? users_.erase(user) : std::next(user);
  }
}

}  // namespace mlcca::serve
