// SPDX-License-Identifier: BSD-2-Clause
// The contents of the journal: what was granted or released at run time and must survive the daemon
// and a reboot, and the effect of each entry. All texts are UTF-8, as on the control socket.
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

/// One of the structs that are generated from journal.proto.
using Entry = decltype(JournalEntry::body);

/// Admit requests that were granted: a range of control::Request in the order of their ids.
class RecordedAdmissions {
 public:
  RecordedAdmissions() = default;
  RecordedAdmissions(std::initializer_list<control::Request> requests) {
    for (const control::Request& r : requests) put(r);
  }

  [[nodiscard]] auto begin() const { return std::views::values(by_id_).begin(); }
  [[nodiscard]] auto end() const { return std::views::values(by_id_).end(); }
  [[nodiscard]] std::size_t size() const { return by_id_.size(); }
  [[nodiscard]] bool empty() const { return by_id_.empty(); }

  /// nullptr if no admission has this id.
  [[nodiscard]] const control::Request* find(std::uint64_t id) const {
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? nullptr : &found->second;
  }
  /// The user who asked for an existing admission.
  [[nodiscard]] std::uint32_t user_of(std::uint64_t id) const { return users_.at(id); }
  /// The gateway that has made an existing admission for this one; empty: none.
  [[nodiscard]] std::string through(std::uint64_t id) const {
    const auto found = through_.find(id);
    return found == through_.end() ? std::string() : found->second;
  }
  /// The admissions that other gateways have made for this one: their ids, and these gateways.
  [[nodiscard]] const std::map<std::uint64_t, std::string>& through_others() const {
    return through_;
  }
  /// The number of admissions of a user.
  [[nodiscard]] std::size_t held_by(std::uint32_t user) const {
    const auto found = held_.find(user);
    return found == held_.end() ? 0 : found->second;
  }
  /// Adds an admission, or replaces the one with the same id.
  void put(control::Request request, std::uint32_t user = 0, const std::string& through = {}) {
    const std::uint64_t id = request.id;
    erase(id);
    by_id_.emplace(id, std::move(request));
    users_.emplace(id, user);
    ++held_[user];
    if (!through.empty()) through_.emplace(id, through);
  }
  void erase(std::uint64_t id) {
    if (by_id_.erase(id) == 0) return;
    through_.erase(id);
    const auto held = held_.find(users_.extract(id).mapped());
    if (--held->second == 0) held_.erase(held);
  }

  bool operator==(const RecordedAdmissions&) const = default;

 private:
  std::map<std::uint64_t, control::Request> by_id_;
  std::unordered_map<std::uint64_t, std::uint32_t> users_;  ///< by id
  std::map<std::uint32_t, std::size_t> held_;               ///< number of admissions, by user
  std::map<std::uint64_t, std::string> through_;            ///< by id, where it is not empty
};

/// Everything that the journal says.
struct Contents {
  RecordedAdmissions admissions;
  /// Subjects ("0x…") of channels that the operator has withdrawn, sorted.
  std::vector<std::string> released;
  /// By subject: an encoded Grants message (records.hpp), never empty.
  std::map<std::string, std::string> granted;
  /// By identity of the port. No entry has ifindex 0.
  std::map<std::string, Gated> gated;
  /// By subject: an encoded Slots message (records.hpp), never empty.
  std::map<std::uint64_t, std::string> enforced;
  /// By network and subject. No entry has an empty `how`.
  std::map<std::pair<std::string, std::uint64_t>, Contradicted> contradicted;
  /// The membership of a cluster; all fields are empty if the gateway is in none.
  Membership membership;
  /// An operator has ended the introduction in audit mode, so later starts do not begin in it.
  bool introduced = false;
  /// The next admission gets this id. Ids are never used twice.
  std::uint64_t next_id = 1;
  bool operator==(const Contents&) const = default;

  /// Applies an entry. An entry about something that does not exist changes nothing.
  void apply(const Entry& entry);

  /// The entry that undoes `entry`, if `entry` were applied now; nullopt if it would change
  /// nothing. next_id is an exception, because it only grows.
  [[nodiscard]] std::optional<Entry> inverse(const Entry& entry) const;
};

}  // namespace mlcca::store
