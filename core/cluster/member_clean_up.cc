// SPDX-License-Identifier: BSD-2-Clause
// Takes entries out of the store that no gateway uses any more.
#include <algorithm>
#include <ranges>
#include <utility>

#include "core/cluster/member.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

/// The most keys that one transaction deletes, and the time after which a refused one is tried
/// again.
constexpr std::size_t kMostCleaned = 64;
constexpr Value kCleanAgain = 60'000'000'000;

/// Whether only the fence and votes of the gateway are left.
bool has_nothing_itself(const LeftRecord& left) {
  return std::ranges::all_of(std::views::values(left.keys), [](const LeftRecord::Key& key) {
    return key.voter || key.kind == Key::Kind::fence || key.kind == Key::Kind::rollout_vote;
  });
}

}  // namespace

/// If the store refuses to delete entries, the role of this user in etcd may lack the right.
void Member::on_cleaned(const Done& done, Value now) {
  if (done.work.kind == Work::Kind::clean && done.fate != Done::Fate::done)
    clean_from_.at(done.work.number) = add_saturating(now, kCleanAgain);
}

/// Entries are deleted only after all gateways have left the former description.
std::optional<Work> Member::clean_up(Value now) const {
  if (!digest_in_force()) return std::nullopt;
  for (std::size_t kind = 0; kind < kUnused; ++kind) {
    if (now < clean_from_[kind]) continue;
    Work clean{.kind = Work::Kind::clean,
               .number = kind,
               .compares = {{.key = keys_->current(), .revision = view_.records().current.mod}}};
    add_unused(static_cast<Unused>(kind), now, clean);
    if (clean.deletes.size() > kMostCleaned) clean.deletes.resize(kMostCleaned);
    if (!clean.deletes.empty()) return clean;
  }
  return std::nullopt;
}

void Member::add_unused(Unused kind, Value now, Work& clean) const {
  if (kind == Unused::own)
    for (const auto& key : std::views::keys(view_.records().strange))
      if (keys_->is_of_removed_network(key, identity_.gateway)) clean.deletes.push_back(key);
  for (const auto& [gateway, left] : view_.records().left) {
    // One gateway at a time, because the compares of the transaction are about that gateway.
    if (kind == Unused::left && clean.deletes.empty()) add_left(gateway, left, now, clean);
    const bool gone = left.member.mod == 0 || view_.is_over(gateway, now);
    for (const auto& [name, key] : left.keys) {
      const bool own = key.kind == Key::Kind::vote && key.voter == identity_.gateway;
      const bool ballot = key.kind == Key::Kind::rollout_vote && gone;
      const bool last = key.kind == Key::Kind::fence && has_nothing_itself(left);
      if ((kind == Unused::own && own) || (kind == Unused::ballots && ballot) ||
          (kind == Unused::fences && last))
        clean.deletes.push_back(name);
    }
  }
}

/// Deletes the beat after all other entries, because beat and fence say that the gateway is dead.
/// The fence is deleted after the beat.
void Member::add_left(const std::string& gateway, const LeftRecord& left, Value now,
                      Work& clean) const {
  if (!view_.is_over(gateway, now)) return;
  std::vector<std::string> others;
  std::vector<std::string> beat;
  std::vector<Compare> compares;
  for (const auto& [name, key] : left.keys) {
    if (key.voter || key.kind == Key::Kind::rollout_vote) continue;
    const bool is_beat = key.kind == Key::Kind::member;
    if (is_beat || key.kind == Key::Kind::fence)
      compares.push_back({.key = name, .revision = key.mod});
    else
      others.push_back(name);
    if (is_beat) beat.push_back(name);
  }
  clean.deletes = others.empty() ? std::move(beat) : std::move(others);
  if (!clean.deletes.empty())
    clean.compares.insert(clean.compares.end(), compares.begin(), compares.end());
}

}  // namespace mlcca::core::cluster
