// SPDX-License-Identifier: BSD-2-Clause
// The numbers of events between programs on the gateway. Each sender has a random number, and
// counts its events from 0, those that are lost as well: so the receiver knows how many are. The
// highest bit of a sender's number says that a datagram is no event: it has the number of the next
// one.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "base/result.hpp"

namespace mlcca::client {

struct LocalCount {
  static constexpr std::uint32_t kNotice = std::uint32_t{1} << 31U;

  std::uint32_t sender = 0;  ///< without that bit
  std::uint32_t next = 0;    ///< after the last one 0 comes again

  /// With a random number of the sender, and no event yet.
  static Result<LocalCount> begin();
};

/// What a receiver has of each sender.
class LocalNumbers {
 public:
  /// Of one user: those that sent least recently are forgotten.
  static constexpr std::size_t kMostOfUser = 16;
  /// Of all users.
  static constexpr std::size_t kMost = 256;

  /// How many events of the sender were lost before this. `notice`: it is no event itself.
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
  std::set<uid_t> forgotten_;  ///< users of whom some are: what is not known may be one of them
  std::uint64_t turn_ = 0;
};

}  // namespace mlcca::client
