// SPDX-License-Identifier: BSD-2-Clause
// Finds the channels that can affect each other because they share something, directly or through
// other channels.
#pragma once
#include <cstddef>
#include <set>
#include <type_traits>
#include <vector>

#include "core/model/progress.hpp"

namespace mlcca::core {

/// Returns the channel and all channels connected with it. `shared_by(channel)` returns a container
/// of the things that the channel uses together with others; `users_of(thing)` returns the channels
/// that want that thing.
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
