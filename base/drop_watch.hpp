// SPDX-License-Identifier: BSD-2-Clause
// Notices that frames are being dropped, and says so without flooding the journal.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace mlcca {

/// Frames that were dropped lately, and in how many seconds until now; 0 frames: none.
struct RecentDrops {
  std::uint64_t frames = 0;
  std::int64_t seconds = 0;
  bool operator==(const RecentDrops&) const = default;
};

/// What happened less than this time ago is recent, s: as often as a monitoring system asks.
inline constexpr std::int64_t kRecent = 300;

/// Remembers counters by key, those that are not 0: most never are. Times are in seconds of any
/// steady clock.
template <class Key>
class DropWatch {
 public:
  /// What goes on being dropped is mentioned again after this time.
  static constexpr std::int64_t kRepeat = 60;
  /// A difference of counters that are read while CPUs count may be behind by one for each.
  static constexpr std::uint64_t kBehind = 1024;

  /// Frames dropped since the last mention, if they are to be mentioned now. In the first round a
  /// counter is only remembered, if it is not 0: what a former daemon counted is not reported
  /// again. Who counts from nothing ends the first round before it samples. Later a counter begins
  /// at 0, and one that is less than before by more than kBehind, or 0, has started again.
  std::optional<std::uint64_t> sample(const Key& key, std::uint64_t dropped, std::int64_t now) {
    if (!began_) began_ = now;
    grown_ = 0;
    if (dropped == 0 && !seen_.contains(key)) return std::nullopt;
    auto [it, fresh] = seen_.try_emplace(key);
    Seen& seen = it->second;
    if (!fresh && is_gone(seen)) seen = {};
    seen.round = round_;
    // It was 0 in the round before, if it was sampled then.
    if (fresh) seen.sampled = before_began_.value_or(now);
    if (fresh && first_) seen.mentioned = seen.counted = dropped;
    if (dropped == 0 || dropped + kBehind < seen.mentioned) restart(seen);
    grown_ = dropped - std::min(dropped, seen.counted);
    follow(seen, dropped, now);
    seen.sampled = now;
    if (dropped <= seen.mentioned || (seen.ever && now - seen.at < kRepeat)) return std::nullopt;
    const std::uint64_t since = dropped - seen.mentioned;
    seen.mentioned = dropped;
    seen.at = now;
    seen.ever = true;
    return since;
  }

  /// Frames dropped between the latest sample and the one before it of its key.
  [[nodiscard]] std::uint64_t grown() const { return grown_; }

  /// Frames dropped since drops of this key began, if there was one in the last kRecent seconds as
  /// far as sample() was given them; otherwise none.
  [[nodiscard]] RecentDrops recent(const Key& key, std::int64_t now) const {
    const auto known = seen_.find(key);
    if (known == seen_.end() || is_gone(known->second)) return {};
    const Seen& seen = known->second;
    if (!is_recent(seen, now)) return {};
    return {seen.counted - seen.began, now - seen.none_until};
  }

  /// What drops mean changes now: those until now are not recent any more. How many of them were
  /// not mentioned yet.
  std::uint64_t close(const Key& key, std::uint64_t dropped, std::int64_t now) {
    if (const auto known = seen_.find(key); known != seen_.end()) known->second.ever = false;
    const auto since = sample(key, dropped, now);
    if (const auto known = seen_.find(key); known != seen_.end())
      known->second.has_grown = known->second.ever = false;
    return since.value_or(0);
  }

  /// All counters have been sampled: a key that was not is gone.
  void end_round() {
    ++round_;
    first_ = false;
    before_began_ = std::exchange(began_, std::nullopt);
  }

  /// Gives back the memory of some of what is gone, the next ones with each call; false once it has
  /// been through all of it.
  bool tidy() {
    auto it = tidied_ ? seen_.upper_bound(*tidied_) : seen_.begin();
    for (std::size_t n = 0; n < kTidied && it != seen_.end(); ++n) {
      tidied_ = it->first;
      it = is_gone(it->second) ? seen_.erase(it) : std::next(it);
    }
    if (it == seen_.end()) tidied_.reset();
    return tidied_.has_value();
  }
  [[nodiscard]] std::size_t size() const { return seen_.size(); }

  /// What was not mentioned yet is mentioned at the next sample, however short ago the last mention
  /// was.
  void wake() {
    for (auto& [key, seen] : seen_) seen.ever = false;
  }

  /// The next round is a first one.
  void forget() {
    seen_.clear();
    first_ = true;
    began_ = before_began_ = std::nullopt;
  }

 private:
  struct Seen {
    std::uint64_t mentioned = 0;
    std::int64_t at = 0;
    bool ever = false;
    std::uint64_t round = 0;
    std::uint64_t counted = 0;    ///< at the latest sample
    std::uint64_t began = 0;      ///< counted when the drops that are recent began
    std::int64_t grew = 0;        ///< when it was last found to be more
    std::int64_t sampled = 0;     ///< the latest sample
    std::int64_t none_until = 0;  ///< the latest sample before the drops that are recent
    bool has_grown = false;
  };
  static constexpr std::size_t kTidied = 64;
  [[nodiscard]] bool is_gone(const Seen& seen) const { return seen.round + 1 < round_; }
  [[nodiscard]] static bool is_recent(const Seen& seen, std::int64_t now) {
    return seen.has_grown && now - seen.grew < kRecent;
  }
  static void restart(Seen& seen) {
    seen.mentioned = seen.counted = 0;
    seen.has_grown = false;
  }
  static void follow(Seen& seen, std::uint64_t dropped, std::int64_t now) {
    if (dropped <= seen.counted) return;
    if (!is_recent(seen, now)) {
      seen.began = seen.counted;
      seen.none_until = seen.sampled;
    }
    seen.counted = dropped;
    seen.grew = now;
    seen.has_grown = true;
  }
  std::map<Key, Seen> seen_;
  std::uint64_t round_ = 0;
  bool first_ = true;
  std::optional<std::int64_t> began_;         ///< when this round did
  std::optional<std::int64_t> before_began_;  ///< when the round before did
  std::uint64_t grown_ = 0;
  std::optional<Key> tidied_;  ///< up to here, since tidy() began at the front
};

}  // namespace mlcca
