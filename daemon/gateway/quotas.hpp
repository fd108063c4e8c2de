// SPDX-License-Identifier: BSD-2-Clause
// How much of the daemon's memory, disk and history one user may take, and all of the control group
// together (docs/reference/limits.md). Bookkeeping only: time comes in as argument, in nanoseconds
// of any steady clock.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "daemon/store/contents.hpp"

namespace mlcca {

class Quotas {
 public:
  /// Admissions that one user holds; root may hold all that others do not.
  static constexpr std::size_t kOfUser = 4'096;
  /// Those of all users but root together.
  static constexpr std::size_t kOfOthers = 12'288;
  static constexpr std::size_t kOfAll = 16'384;

  /// Pairs of a publisher and a subscriber that admissions of all users add to what is described.
  /// Each takes some 270 bytes: 283 MB.
  static constexpr std::size_t kPairs = 1'048'576;

  /// Admissions that wait for the store, and are decided one after the other: of one user, of all
  /// users but root, and of all.
  static constexpr std::size_t kWaitingOfUser = 64;
  static constexpr std::size_t kWaitingOfOthers = 192;
  static constexpr std::size_t kWaitingOfAll = 256;
  struct Waiting {
    std::size_t of_user = 0;
    std::size_t of_others = 0;  ///< of all users but root
    std::size_t all = 0;
  };

  /// Rows of the history that changes of one user may make: so many at once, and so many more a
  /// second.
  struct Rows {
    std::uint64_t at_once = 0;
    std::uint64_t per_second = 0;
  };
  static constexpr Rows kRowsOfUser{10'000, 5};
  static constexpr Rows kRowsOfRoot{100'000, 1'000};
  /// The work of a reload counts as so many, beside what it reports: that of 100,000 channels takes
  /// about as long as these take to be made up for.
  static constexpr std::uint64_t kRowsOfReload = 50;

  /// Why a user must not have one more admission, and what to do; nothing when he may.
  [[nodiscard]] static std::optional<std::string> refuse_admission(uid_t user,
                                                                   const store::Admissions& held);
  /// Why no further admission of a user can wait, and what to do; nothing when it can.
  [[nodiscard]] static std::optional<std::string> refuse_waiting(uid_t user, const Waiting& now);
  /// Why there must not be so many more pairs, and what to do; nothing when there may.
  [[nodiscard]] static std::optional<std::string> refuse_pairs(std::size_t now, std::size_t more);
  /// Why a user must not change anything now that counts as so many rows at least; nothing when he
  /// may.
  [[nodiscard]] std::optional<std::string> refuse_change(uid_t user, std::uint64_t now,
                                                         std::uint64_t least = 1) const;
  /// What a change of his has made. It may be more than is left: then he waits the longer.
  void charge(uid_t user, std::uint64_t rows, std::uint64_t now);
  /// Users who have not all of their rows left.
  [[nodiscard]] std::size_t users() const { return paid_until_.size(); }

 private:
  std::map<uid_t, std::uint64_t> paid_until_;  ///< when all that he has made is made up for
};

}  // namespace mlcca
