// SPDX-License-Identifier: BSD-2-Clause
// What was granted or taken back at run time and must survive the daemon and a reboot, and the
// entries of the journal that change it. All texts are UTF-8, as on the control socket.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <ranges>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "control/messages.hpp"
#include "daemon/store/messages.hpp"

namespace mlcca::store {

/// One of the structs that are made of journal.proto.
using Entry = decltype(JournalEntry::body);

/// Admit requests that were granted: a range of control::Request, oldest first (by id).
class Admissions {
 public:
  Admissions() = default;
  Admissions(std::initializer_list<control::Request> requests) {
    for (const control::Request& r : requests) put(r);
  }

  [[nodiscard]] auto begin() const { return std::views::values(by_id_).begin(); }
  [[nodiscard]] auto end() const { return std::views::values(by_id_).end(); }
  [[nodiscard]] std::size_t size() const { return by_id_.size(); }
  [[nodiscard]] bool empty() const { return by_id_.empty(); }

  /// Null when there is none of this id.
  [[nodiscard]] const control::Request* find(std::uint64_t id) const {
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? nullptr : &found->second;
  }
  /// Who asked for one that is there.
  [[nodiscard]] std::uint32_t user_of(std::uint64_t id) const { return users_.at(id); }
  /// How many there are of a user.
  [[nodiscard]] std::size_t held_by(std::uint32_t user) const {
    const auto found = held_.find(user);
    return found == held_.end() ? 0 : found->second;
  }
  /// Replaces the one of the same id.
  void put(control::Request request, std::uint32_t user = 0) {
    const std::uint64_t id = request.id;
    erase(id);
    by_id_.emplace(id, std::move(request));
    users_.emplace(id, user);
    ++held_[user];
  }
  void erase(std::uint64_t id) {
    if (by_id_.erase(id) == 0) return;
    const auto held = held_.find(users_.extract(id).mapped());
    if (--held->second == 0) held_.erase(held);
  }

  bool operator==(const Admissions&) const = default;

 private:
  std::map<std::uint64_t, control::Request> by_id_;
  std::unordered_map<std::uint64_t, std::uint32_t> users_;  ///< of each
  std::map<std::uint32_t, std::size_t> held_;               ///< by user
};

struct Contents {
  Admissions admissions;
  /// Channels (by subject, "0x…") that the operator has released, sorted.
  std::vector<std::string> released;
  /// By subject: a Grants message (records.hpp); never empty.
  std::map<std::string, std::string> granted;
  /// By identity; never of ifindex 0.
  std::map<std::string, Gated> gated;
  /// By subject: a Slots message (records.hpp); never empty.
  std::map<std::uint64_t, std::string> enforced;
  /// By network and subject; never of empty words.
  std::map<std::pair<std::string, std::uint64_t>, Contradicted> contradicted;
  /// As what the gateway is a member of a cluster; nothing is in it where it is in none.
  Membership membership;
  /// A start that is to begin in audit mode does not: an operator has ended that.
  bool introduced = false;
  /// The next admission gets this id; ids are never used twice.
  std::uint64_t next_id = 1;
  bool operator==(const Contents&) const = default;

  /// What an entry says. One that names what is not there changes nothing.
  void apply(const Entry& entry);

  /// The entry that takes `entry` back if it were applied now (except for next_id, which only
  /// grows); nothing when it would change nothing.
  [[nodiscard]] std::optional<Entry> inverse(const Entry& entry) const;
};

}  // namespace mlcca::store
