// SPDX-License-Identifier: BSD-2-Clause
#include "client/local_numbers.hpp"

#include <sys/random.h>

#include <algorithm>
#include <iterator>

#include "base/system_error.hpp"

namespace mlcca::client {

Result<LocalCount> LocalCount::begin() {
  LocalCount count;
  if (::getrandom(&count.sender, sizeof count.sender, 0) != sizeof count.sender)
    return system_error("getrandom");
  count.sender &= ~kNotice;
  return count;
}

std::uint64_t LocalNumbers::missed(uid_t user, std::uint32_t sender, std::uint32_t number,
                                   bool notice) {
  const Key key{user, sender};
  auto known = senders_.find(key);
  if (known == senders_.end()) {
    make_room(user);
    // If senders of this user were forgotten, this may be one of them, whose earlier losses are
    // counted.
    const std::uint32_t first = forgotten_.contains(user) ? number : 0;
    known = senders_.emplace(key, Sender{.next = first}).first;
  }
  const std::uint32_t expected = known->second.next;
  known->second = {.next = notice ? number : number + 1, .used = ++turn_};
  // Datagrams of one sender arrive in order. A lower number is of a sender that does not count like
  // this.
  const std::uint32_t gap = number - expected;
  constexpr std::uint32_t half = std::uint32_t{1} << 31U;
  return gap < half ? gap : 0;
}

void LocalNumbers::make_room(uid_t user) {
  const auto of_user = [user](const auto& one) { return one.first.first == user; };
  const auto own = static_cast<std::size_t>(std::ranges::count_if(senders_, of_user));
  if (own < kMostOfUser && senders_.size() < kMost) return;
  auto oldest = senders_.end();
  for (auto it = senders_.begin(); it != senders_.end(); ++it) {
    if (own >= kMostOfUser && !of_user(*it)) continue;
    if (oldest == senders_.end() || it->second.used < oldest->second.used) oldest = it;
  }
  if (forgotten_.size() < kMost) forgotten_.insert(oldest->first.first);
  senders_.erase(oldest);
}

}  // namespace mlcca::client
