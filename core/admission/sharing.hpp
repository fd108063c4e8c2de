// SPDX-License-Identifier: BSD-2-Clause
// Which channels can be in each other's way: those that share something, directly or over others.
#pragma once
#include <cstddef>
#include <set>
#include <type_traits>
#include <vector>

#include "core/model/progress.hpp"

namespace mlcca::core {

/// The channel itself, and everything that shares with it. `shared_by(channel)`: what it shares
/// with others, in a container. `users_of(thing)`: the channels that want that.
template <class SharedBy, class UsersOf>
[[nodiscard]] std::set<std::size_t> sharing_with(std::size_t channel, SharedBy&& shared_by,
                                                 UsersOf&& users_of) {
  using Things = std::remove_cvref_t<decltype(shared_by(channel))>;
  std::set<std::size_t> channels{channel};
  std::set<typename Things::value_type> seen;
  std::vector<std::size_t> open{channel};
  while (!open.empty()) {
    const std::size_t next = open.back();
    open.pop_back();
    for (const auto& thing : shared_by(next)) {
      if (!seen.insert(thing).second) continue;
      for (const std::size_t user : users_of(thing)) {
        if (channels.insert(user).second) open.push_back(user);
        Progress::step();
      }
    }
  }
  return channels;
}

}  // namespace mlcca::core
