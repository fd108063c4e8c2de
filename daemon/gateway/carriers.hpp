// SPDX-License-Identifier: BSD-2-Clause
// Programs that carry events between networks, as far as they are connected: each asks what its
// user is to carry.
#pragma once
#include <sys/types.h>

#include <algorithm>
#include <cstdint>
#include <map>

namespace mlcca {

class Carriers {
 public:
  void add(std::uint64_t session, uid_t user) { users_[session] = user; }
  void session_closed(std::uint64_t session) { users_.erase(session); }
  [[nodiscard]] bool has(uid_t user) const {
    return std::ranges::any_of(users_, [user](const auto& one) { return one.second == user; });
  }

 private:
  std::map<std::uint64_t, uid_t> users_;  ///< by session
};

}  // namespace mlcca
