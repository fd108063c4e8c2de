// SPDX-License-Identifier: BSD-2-Clause
// Numbering of the events between programs on the gateway, by which a receiver knows how many were
// lost.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "base/result.hpp"

namespace mlcca::client {

/// The number of a sender's next event. Each sender has a random number and counts all its events
/// from 0, including those that are lost. A sender number with the highest bit set marks a notice,
/// a datagram without event that states the number of the next event.
struct LocalCount {
  static constexpr std::uint32_t kNotice = std::uint32_t{1} << 31U;

  std::uint32_t sender = 0;  ///< number of the sender, without the bit of a notice
  std::uint32_t next = 0;    ///< number of its next event; wraps to 0

  /// A sender with a random number that has not sent any event.
  static Result<LocalCount> begin();
};

/// Counts lost events by the numbers that a receiver has seen of each sender.
class LocalNumbers {
 public:
  /// Senders of one user that are remembered; the one that was quiet for longest is forgotten
  /// first.
  static constexpr std::size_t kMostOfUser = 16;
  /// Senders of all users that are remembered.
  static constexpr std::size_t kMost = 256;

  /// Returns how many events of this sender were lost before this datagram. `number`: the number in
  /// the datagram; `notice`: it is a notice and no event.
  [[nodiscard]] std::uint64_t missed(uid_t user, std::uint32_t sender, std::uint32_t number,
                                     bool notice);
  [[nodiscard]] std::size_t senders() const { return senders_.size(); }

 private:
  using Key = std::pair<uid_t, std::uint32_t>;
  struct Sender {
    std::uint32_t next = 0;
    std::uint64_t used = 0;
  };
  void make_room(uid_t user);

  std::map<Key, Sender> senders_;
  std::set<uid_t> forgotten_;  ///< users of which senders were forgotten: the first event of an
                               ///< unknown sender of theirs need not have number 0
  std::uint64_t turn_ = 0;
};

}  // namespace mlcca::client
