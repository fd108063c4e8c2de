// SPDX-License-Identifier: BSD-2-Clause
// Keeps which programs that carry events between networks (such as mlcca-relay) are connected, and
// which late events they have reported.
#pragma once
#include <sys/types.h>

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/model/system.hpp"

namespace mlcca {

class Carriers {
 public:
  void add(std::uint64_t session, uid_t user) { users_[session] = user; }
  void session_closed(std::uint64_t session) { users_.erase(session); }
  [[nodiscard]] bool has(uid_t user) const {
    return std::ranges::any_of(users_, [user](const auto& one) { return one.second == user; });
  }
  /// Whether this session belongs to a program that carries the channels of this user.
  [[nodiscard]] bool is(std::uint64_t session, uid_t user) const {
    const auto known = users_.find(session);
    return known != users_.end() && known->second == user;
  }

  /// A channel that a program carries from a publisher to a network.
  struct Carried {
    core::Subject subject = 0;
    std::string publisher = {};
    std::string to = {};
    auto operator<=>(const Carried&) const = default;
  };
  /// The latest report of late events of a channel.
  struct Late {
    std::uint64_t at = 0;  ///< CLOCK_MONOTONIC
    std::uint64_t events = 0;
    std::uint64_t longest_ns = 0;
  };
  /// ns between two reports of one channel.
  static constexpr std::uint64_t kPause = 10'000'000'000;
  /// ns for which a report counts.
  static constexpr std::uint64_t kCounts = 60'000'000'000;
  /// False if the latest report of this channel is too recent, or if there is no room for another
  /// channel; then nothing is noted.
  [[nodiscard]] bool note_late(const Carried& carried, const Late& late) {
    std::erase_if(late_, [&](const auto& one) { return late.at - one.second.at >= kCounts; });
    const auto known = late_.find(carried);
    // The clock of the program differs from ours: it may report a little earlier than it should.
    if (known != late_.end() ? late.at - known->second.at < kPause / 2 : late_.size() >= kMostLate)
      return false;
    late_[carried] = late;
    return true;
  }
  /// What was reported in the last kCounts; nullopt if nothing was.
  [[nodiscard]] std::optional<Late> late(const Carried& carried, std::uint64_t now) const {
    const auto known = late_.find(carried);
    if (known == late_.end() || now - known->second.at >= kCounts) return std::nullopt;
    return known->second;
  }
  [[nodiscard]] bool any_late() const { return !late_.empty(); }

 private:
  static constexpr std::size_t kMostLate = 4096;

  std::map<std::uint64_t, uid_t> users_;  ///< by session
  std::map<Carried, Late> late_;
};

}  // namespace mlcca
