// SPDX-License-Identifier: BSD-2-Clause
// Detects that frames are being dropped, and limits how often that is reported in the journal.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace mlcca {

/// Frames that were dropped recently. `frames` is 0 if there were none; otherwise `seconds` is the
/// time from the last sample before these drops until now.
struct RecentDrops {
  std::uint64_t frames = 0;
  std::int64_t seconds = 0;
  bool operator==(const RecentDrops&) const = default;
};

/// Drops count as recent for this long, in seconds: monitoring systems sample at least as often.
inline constexpr std::int64_t kRecent = 300;

/// Compares drop counters with their former values and decides when an increase is reported. The
/// caller samples all counters in rounds, ended by end_round(). A counter is remembered under its
/// key only once it is not 0, because most never are. Times are in seconds of any clock that never
/// goes back.
template <class Key>
class DropWatch {
 public:
  /// The shortest time between two reports about the same key, in seconds.
  static constexpr std::int64_t kRepeat = 60;
  /// A sum over the counters of all CPUs that is read while the CPUs count may be smaller than the
  /// former sum by 1 for each CPU. A sum that is smaller by no more than this is not a restart.
  static constexpr std::uint64_t kBehind = 1024;

  /// Takes the value of a counter. Returns the frames that were dropped since the last report if
  /// they are to be reported now, nullopt otherwise. In the first round a value other than 0 is
  /// only remembered, so that what a former daemon counted is not reported again; a caller whose
  /// counters begin at 0 calls end_round() before its first sample. A counter that becomes 0, or
  /// smaller by more than kBehind, has restarted at 0.
  std::optional<std::uint64_t> sample(const Key& key, std::uint64_t dropped, std::int64_t now) {
    if (!began_) began_ = now;
    grown_ = 0;
    if (dropped == 0 && !seen_.contains(key)) return std::nullopt;
    auto [it, fresh] = seen_.try_emplace(key);
    Seen& seen = it->second;
    if (!fresh && is_gone(seen)) seen = {};
    seen.round = round_;
    // A key without an entry had the value 0 in the round before, if it was sampled then.
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

  /// How much the counter of the latest sample() has grown since the sample before it of the same
  /// key.
  [[nodiscard]] std::uint64_t grown() const { return grown_; }

  /// The frames dropped since the present series of drops of `key` began. A series ends when no
  /// drop was sampled for kRecent seconds; then, and for an unknown key, `frames` is 0.
  [[nodiscard]] RecentDrops recent(const Key& key, std::int64_t now) const {
    const auto known = seen_.find(key);
    if (known == seen_.end() || is_gone(known->second)) return {};
    const Seen& seen = known->second;
    if (!is_recent(seen, now)) return {};
    return {seen.counted - seen.began, now - seen.none_until};
  }

  /// Ends the present series of drops because drops mean something else from now on, such as when
  /// the delivery becomes granted. Returns how many of them were not reported yet.
  std::uint64_t close(const Key& key, std::uint64_t dropped, std::int64_t now) {
    if (const auto known = seen_.find(key); known != seen_.end()) known->second.ever = false;
    const auto since = sample(key, dropped, now);
    if (const auto known = seen_.find(key); known != seen_.end())
      known->second.has_grown = known->second.ever = false;
    return since.value_or(0);
  }

  /// Ends a round, in which all counters have been sampled: a key that was not sampled in it is
  /// gone once the next round ends, too.
  void end_round() {
    ++round_;
    first_ = false;
    before_began_ = std::exchange(began_, std::nullopt);
  }

  /// Frees the entries of some keys that are gone, a bounded number in each call. Returns false
  /// once it has been through all keys.
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

  /// Lets the next sample report what was not reported yet, even within kRepeat of the last report.
  void wake() {
    for (auto& [key, seen] : seen_) seen.ever = false;
  }

  /// Forgets all counters; the next round is a first round again.
  void forget() {
    seen_.clear();
    first_ = true;
    began_ = before_began_ = std::nullopt;
  }

 private:
  struct Seen {
    /// The value and the time of the last report; `ever` is false if the next one need not wait.
    std::uint64_t mentioned = 0;
    std::int64_t at = 0;
    bool ever = false;
    std::uint64_t round = 0;
    std::uint64_t counted = 0;    ///< the value at the latest sample
    std::uint64_t began = 0;      ///< the value before the first of the recent drops
    std::int64_t grew = 0;        ///< when the value was last found to have grown
    std::int64_t sampled = 0;     ///< when the latest sample was taken
    std::int64_t none_until = 0;  ///< when the last sample before the recent drops was taken
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
  std::optional<std::int64_t> began_;         ///< when the first sample of this round was taken
  std::optional<std::int64_t> before_began_;  ///< the same of the round before
  std::uint64_t grown_ = 0;
  std::optional<Key> tidied_;  ///< the last key that tidy() has examined; none: it starts from the
                               ///< first one
};

}  // namespace mlcca
