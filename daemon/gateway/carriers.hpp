// SPDX-License-Identifier: BSD-2-Clause
// Programs that carry events between networks, as far as they are connected: each asks what its
// user is to carry, and reports what it carried too late.
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
  /// The session is of a program that carries what is of this user.
  [[nodiscard]] bool is(std::uint64_t session, uid_t user) const {
    const auto known = users_.find(session);
    return known != users_.end() && known->second == user;
  }

  /// What a program carries to a network.
  struct Carried {
    core::Subject subject = 0;
    std::string publisher = {};
    std::string to = {};
    auto operator<=>(const Carried&) const = default;
  };
  struct Late {
    std::uint64_t at = 0;  ///< CLOCK_MONOTONIC
    std::uint64_t events = 0;
    std::uint64_t longest_ns = 0;
  };
  /// Between two reports of one, ns.
  static constexpr std::uint64_t kPause = 10'000'000'000;
  /// A report counts for so long, ns.
  static constexpr std::uint64_t kCounts = 60'000'000'000;
  /// False: the last one is less than kPause ago, or there is no room for one more.
  [[nodiscard]] bool note_late(const Carried& carried, const Late& late) {
    std::erase_if(late_, [&](const auto& one) { return late.at - one.second.at >= kCounts; });
    const auto known = late_.find(carried);
    // A program's clock is not ours: it may send a little sooner than it should.
    if (known != late_.end() ? late.at - known->second.at < kPause / 2 : late_.size() >= kMostLate)
      return false;
    late_[carried] = late;
    return true;
  }
  /// What was reported in the last kCounts.
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
