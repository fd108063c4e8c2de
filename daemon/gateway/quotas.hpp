// SPDX-License-Identifier: BSD-2-Clause
// Limits how much of the daemon's memory, disk and history one user may take, and all users
// together (docs/reference/limits.md). Bookkeeping only: times are arguments, in ns of any steady
// clock.
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
  /// The admissions that one user may hold. Root may hold all that others do not hold.
  static constexpr std::size_t kOfUser = 4'096;
  /// The admissions of all users except root together.
  static constexpr std::size_t kOfOthers = 12'288;
  static constexpr std::size_t kOfAll = 16'384;

  /// Pairs of a publisher and a subscriber that run-time admissions of all users may add to those
  /// of the description. Each takes about 270 bytes: 283 MB.
  static constexpr std::size_t kPairs = 1'048'576;

  /// Admissions that may wait for the store, where they are decided one after the other: of one
  /// user, of all users except root, and of all.
  static constexpr std::size_t kWaitingOfUser = 64;
  static constexpr std::size_t kWaitingOfOthers = 192;
  static constexpr std::size_t kWaitingOfAll = 256;
  /// The same that another gateway has asked for, and all other gateways together.
  static constexpr std::size_t kWaitingOfGateway = 16;
  static constexpr std::size_t kWaitingOfGateways = 64;
  struct Waiting {
    std::size_t of_user = 0;    ///< or of another gateway
    std::size_t of_others = 0;  ///< of all users except root, or of all other gateways
    std::size_t all = 0;
  };

  /// Rows of the history that the changes of one user may make: a burst, and a rate per second.
  struct Rows {
    std::uint64_t at_once = 0;
    std::uint64_t per_second = 0;
  };
  static constexpr Rows kRowsOfUser{10'000, 5};
  static constexpr Rows kRowsOfRoot{100'000, 1'000};
  /// The rows that a reload is charged with in addition to those that it writes. The work of a
  /// reload of 100,000 channels takes about as long as the rate needs to restore these rows.
  static constexpr std::uint64_t kRowsOfReload = 50;

  /// Why a user may have no further admission, and what to do; nullopt if they may.
  [[nodiscard]] static std::optional<std::string> refuse_admission(
      uid_t user, const store::RecordedAdmissions& held);
  /// Why no further admission of a user may wait, and what to do; nullopt if it may.
  [[nodiscard]] static std::optional<std::string> refuse_waiting(uid_t user, const Waiting& now);
  /// The same for an admission that another gateway asks for.
  [[nodiscard]] static std::optional<std::string> refuse_waiting_for(const std::string& gateway,
                                                                     const Waiting& now);
  /// Why there may not be `more` pairs in addition to `now`, and what to do; nullopt if there may.
  [[nodiscard]] static std::optional<std::string> refuse_pairs(std::size_t now, std::size_t more);
  /// Why a user may change nothing now that makes at least `least` rows; nullopt if they may.
  [[nodiscard]] std::optional<std::string> refuse_change(uid_t user, std::uint64_t now,
                                                         std::uint64_t least = 1) const;
  /// Charges a user with the rows that a change has made. They may exceed what is left; then the
  /// user has to wait longer.
  void charge(uid_t user, std::uint64_t rows, std::uint64_t now);
  /// The number of users whose budget is not full.
  [[nodiscard]] std::size_t users() const { return paid_until_.size(); }

 private:
  std::map<uid_t, std::uint64_t> paid_until_;  ///< when the budget is full again, by user
};

}  // namespace mlcca
