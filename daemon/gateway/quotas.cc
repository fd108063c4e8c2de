// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/quotas.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace mlcca {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr uid_t kRoot = 0;

const Quotas::Rows& rows_of(uid_t user) {
  return user == kRoot ? Quotas::kRowsOfRoot : Quotas::kRowsOfUser;
}

}  // namespace

std::optional<std::string> Quotas::refuse_admission(uid_t user,
                                                    const store::RecordedAdmissions& held) {
  constexpr const char* to_do =
      "release some ('mlccactl release --id NUMBER'), or give them leases that end";
  const std::size_t own = held.held_by(user);
  const std::size_t others = held.size() - held.held_by(kRoot);
  if (user != kRoot && own >= kOfUser)
    return fmt::format("user {} holds {} admissions, and one user may hold {}: {}", user, own,
                       kOfUser, to_do);
  if (user != kRoot && others >= kOfOthers)
    return fmt::format(
        "all users but root hold {} admissions together ({} of them are of user {}), and may hold "
        "{}: {}",
        others, own, user, kOfOthers, to_do);
  if (held.size() >= kOfAll)
    return fmt::format(
        "there are {} admissions ({} of them are of user {}), and there may be {}: "
        "{}",
        held.size(), own, user, kOfAll, to_do);
  return std::nullopt;
}

std::optional<std::string> Quotas::refuse_waiting(uid_t user, const Waiting& now) {
  constexpr const char* to_do = "ask again in a few seconds";
  if (user != kRoot && now.of_user >= kWaitingOfUser)
    return fmt::format("{} admissions of user {} wait for the store, and may not be more: {}",
                       now.of_user, user, to_do);
  if (now.all >= kWaitingOfAll || (user != kRoot && now.of_others >= kWaitingOfOthers))
    return fmt::format("{} admissions wait for the store, and may not be more: {}", now.all, to_do);
  return std::nullopt;
}

std::optional<std::string> Quotas::refuse_waiting_for(const std::string& gateway,
                                                      const Waiting& now) {
  if (now.of_user >= kWaitingOfGateway)
    return fmt::format("{} admissions that {} has asked for wait here, and may not be more",
                       now.of_user, gateway);
  if (now.of_others >= kWaitingOfGateways)
    return fmt::format(
        "{} admissions that other gateways have asked for wait here, and may not be "
        "more",
        now.of_others);
  return std::nullopt;
}

std::optional<std::string> Quotas::refuse_pairs(std::size_t now, std::size_t more) {
  if (now + more <= kPairs) return std::nullopt;
  return fmt::format(
      "admissions have added {} pairs of a publisher and a subscriber, this one would add {}, and "
      "there may be {}: release some ('mlccactl release --id NUMBER'), or describe them",
      now, more, kPairs);
}

std::optional<std::string> Quotas::refuse_change(uid_t user, std::uint64_t now,
                                                 std::uint64_t least) const {
  const auto known = paid_until_.find(user);
  if (known == paid_until_.end() || known->second <= now) return std::nullopt;
  const Rows& rows = rows_of(user);
  const std::uint64_t each = kSecond / rows.per_second;
  const std::uint64_t owed = known->second - now;
  const std::uint64_t then = owed + least * each;
  if (then <= rows.at_once * each) return std::nullopt;
  const std::uint64_t wait = then - rows.at_once * each;
  const std::string this_one = least > 1 ? fmt::format(", this one as {} at least", least) : "";
  return fmt::format(
      "changes of user {} lately count as {} rows of the history{}, and one user may make {} at "
      "once and {} a second: ask again in {} s ('withdraw', 'release' and the end of audit mode do "
      "not wait)",
      user, (owed + each - 1) / each, this_one, rows.at_once, rows.per_second,
      (wait + kSecond - 1) / kSecond);
}

void Quotas::charge(uid_t user, std::uint64_t rows, std::uint64_t now) {
  std::erase_if(paid_until_, [now](const auto& u) { return u.second <= now; });
  if (rows == 0) return;
  const auto [known, fresh] = paid_until_.try_emplace(user, now);
  known->second += rows * (kSecond / rows_of(user).per_second);
}

}  // namespace mlcca
