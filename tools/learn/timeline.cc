// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "tools/learn/frame.hpp"

namespace mlcca::learn {
namespace {

/// So many frames must precede a pause, within so long a time.
constexpr std::uint64_t kFewestFrames = 32;
constexpr std::uint64_t kShortestActive = 1'000'000'000;  // ns
/// A recording may begin shortly before a pause. Then it must be so much longer than the longest
/// other time without a frame, after so many frames within so long a time.
constexpr std::uint64_t kEarly = 100;
constexpr std::uint64_t kFramesEarly = 128;
constexpr std::uint64_t kActiveEarly = 100'000'000;  // ns

/// A time stamp as in candump, so that it can be searched for: 1436509052.249713.
std::string stamp(std::uint64_t ns) {
  return fmt::format("{}.{:06}", ns / 1'000'000'000, ns / 1000 % 1'000'000);
}

/// A span with three digits.
std::string span_words(std::uint64_t ns) {
  std::uint64_t unit = 1;
  while (ns / unit >= 1000) unit *= 10;
  return core::format_value(Attribute::latency, ns / unit * unit);
}

}  // namespace

Stretch Timeline::take(std::uint64_t ns, std::uint32_t recording) {
  ++frames_;
  if (ranges_.empty() || ranges_.back().recording != recording) {
    begin(ns, recording);
    return stretch_;
  }
  Range& range = ranges_.back();
  range.first = std::min(range.first, ns);
  range.last = std::max(range.last, ns);
  if (ns + kTooClose > last_ && ns < last_ + kTooClose) ++too_close_;
  if (ns + kDisorder < last_) {
    if (times_back_++ == 0) first_back_ = {recording, last_, ns};
    last_ = ns;
    ++stretch_.clock;
  } else if (ns > last_) {
    go_on(ns, times_longer());
  }
  return stretch_;
}

/// Begins a recording: it continues the one before, or has a clock of its own.
void Timeline::begin(std::uint64_t ns, std::uint32_t recording) {
  const bool is_first = ranges_.empty();
  const bool has_dates = !is_first && ns >= kFirstDate && last_ >= kFirstDate;
  ranges_.push_back({recording, ns, ns});
  if (is_first) {
    last_ = ns;
  } else if (!has_dates || ns + kDisorder < last_) {
    last_ = ns;
    ++stretch_.clock;
  } else if (ns > last_) {
    go_on(ns, kFarLonger);
  }
}

std::uint64_t Timeline::times_longer() const {
  if (frames_ > kFewestFrames && active_ >= kShortestActive) return kFarLonger;
  return frames_ > kFramesEarly && active_ >= kActiveEarly ? kEarly : 0;
}

void Timeline::go_on(std::uint64_t ns, std::uint64_t times) {
  const std::uint64_t gap = ns - last_;
  last_ = ns;
  if (times != 0 && gap >= kPause && gap / times > longest_) {
    ++pauses_;
    longest_pause_ = std::max(longest_pause_, gap);
    ++stretch_.part;
    return;
  }
  longest_ = std::max(longest_, gap);
  covered_ += gap;
  if (gap < kPause) active_ += gap;
}

// --- notes ---------------------------------------------------------------------------------------

std::vector<std::string> Timeline::notes(const std::string& interface,
                                         std::span<const std::string> recordings) const {
  std::vector<std::string> out;
  if (times_back_ != 0)
    out.push_back(fmt::format(
        "{}: time goes back by {} in {}, to {}{}: no gap between events is counted there",
        interface, span_words(first_back_.from - first_back_.to), recordings[first_back_.recording],
        stamp(first_back_.to),
        times_back_ == 1 ? "" : fmt::format(", and {} times in all", times_back_)));
  if (pauses_ != 0)
    out.push_back(
        fmt::format("{}: {} in which nothing at all came, {}of {}: {} no gap of a channel",
                    interface, many(pauses_, "pause"), pauses_ == 1 ? "" : "the longest ",
                    span_words(longest_pause_), pauses_ == 1 ? "it is" : "they are"));
  note_order(interface, recordings, out);
  return out;
}

/// Notes recordings in the wrong order and of the same time, each kind with its first pair.
void Timeline::note_order(const std::string& interface, std::span<const std::string> recordings,
                          std::vector<std::string>& out) const {
  std::string earlier;
  std::string same;
  for (std::size_t i = 1; i < ranges_.size(); ++i) {
    const Range& one = ranges_[i];
    for (std::size_t j = 0; j < i; ++j) {
      const Range& before = ranges_[j];
      if (one.first < kFirstDate || before.first < kFirstDate) continue;
      const bool overlaps =
          one.first + kDisorder < before.last && before.first + kDisorder < one.last;
      if (overlaps && same.empty())
        same = fmt::format(
            "{}: {} has frames of the same time as {}: what is in both is counted twice", interface,
            recordings[one.recording], recordings[before.recording]);
      if (j + 1 == i && !overlaps && one.first < before.first && earlier.empty())
        earlier = fmt::format(
            "{}: {} begins before {}, and each is taken for itself: state the earlier "
            "one first",
            interface, recordings[one.recording], recordings[before.recording]);
    }
  }
  if (!earlier.empty()) out.push_back(std::move(earlier));
  if (!same.empty()) out.push_back(std::move(same));
}

}  // namespace mlcca::learn
