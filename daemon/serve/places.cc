// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/places.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>
#include <utility>

namespace mlcca::serve {
namespace {

constexpr std::size_t kMostBesideRoot = kMostPlaces - kPlacesOfRoot;

using Concerns = std::function<bool(const Held&)>;

/// Which connections leave no place for one more of this standing; null if there is a place.
/// Connections of the same standing are checked before all of them.
Concerns who_fills_it(Standing standing, std::span<const Held> held) {
  const auto fills = [held](const Concerns& concerns, std::size_t most) {
    return std::cmp_greater_equal(std::ranges::count_if(held, concerns), most);
  };
  if (standing != Standing::root) {
    const std::size_t for_the_rest =
        standing == Standing::member ? kPlacesOfOthers : kPlacesOfMembers;
    Concerns alike = [standing](const Held& h) { return h.standing == standing; };
    if (fills(alike, kMostBesideRoot - for_the_rest)) return alike;
    Concerns beside_root = [](const Held& h) { return h.standing != Standing::root; };
    if (fills(beside_root, kMostBesideRoot)) return beside_root;
  }
  Concerns all = [](const Held&) { return true; };
  if (fills(all, kMostPlaces)) return all;
  return nullptr;
}

std::size_t most_of_one(Standing standing) {
  if (standing == Standing::root) return kMostPlaces;
  return standing == Standing::member ? kMostOfMember : kMostOfOther;
}

Admittance refusal(std::string why) { return {std::move(why), std::nullopt, 0}; }

}  // namespace

Admittance place_for(uid_t uid, Standing standing, std::span<const Held> held) {
  const auto of = [held](uid_t user) {
    return static_cast<std::size_t>(std::ranges::count(held, user, &Held::uid));
  };
  const std::size_t mine = of(uid);
  const std::size_t most = most_of_one(standing);
  if (mine >= most)
    return refusal("you hold " + std::to_string(mine) + " connections, and one user may hold " +
                   std::to_string(most));
  const Concerns concerned = who_fills_it(standing, held);
  if (!concerned) return {};
  std::map<uid_t, std::size_t> numbers;
  for (const Held& h : held) ++numbers[h.uid];
  const Held* closes = nullptr;
  const auto rank = [&numbers](const Held& h) {
    return std::tuple(~numbers.at(h.uid), h.uid, h.use, h.active);
  };
  for (const Held& h : held) {
    // After the closing, that user must not have fewer connections than the new one.
    if (!concerned(h) || h.use == Use::owns || numbers.at(h.uid) <= mine + 1) continue;
    if (closes == nullptr || rank(h) < rank(*closes)) closes = &h;
  }
  if (closes == nullptr) return refusal("too many clients are connected");
  return {{}, *closes, numbers.at(closes->uid)};
}

}  // namespace mlcca::serve
