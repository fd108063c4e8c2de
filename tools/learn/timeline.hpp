// SPDX-License-Identifier: BSD-2-Clause
// Where the time of an interface goes on, and where it does not: recordings of other days, clocks
// that were set back, parts in the wrong order, and pauses in which nothing came at all. Gaps over
// such places say nothing of a channel.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace mlcca::learn {

/// A time that goes on: by one clock, and in it between two pauses.
struct Stretch {
  std::uint32_t clock = 0;
  std::uint32_t part = 0;
  bool operator==(const Stretch&) const = default;
};

class Timeline {
 public:
  /// Frames that several queues of a controller hand over are up to that much out of order, ns.
  static constexpr std::uint64_t kDisorder = 10'000'000;
  /// The shortest time without any frame that is a pause, ns.
  static constexpr std::uint64_t kPause = 1'000'000'000;
  /// A pause is so many times as long as all other times without a frame.
  static constexpr std::uint64_t kFarLonger = 10;

  /// A frame at `ns`, of the recording with that number. Gives the stretch of time that it is in:
  /// from one stretch to another no gap counts.
  Stretch take(std::uint64_t ns, std::uint32_t recording);

  /// When the first event came of the first recording, and the latest one, by which clock.
  [[nodiscard]] std::uint64_t first() const { return ranges_.empty() ? 0 : ranges_.front().first; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  [[nodiscard]] std::uint32_t clock() const { return stretch_.clock; }
  /// Ways of `interface` through time that a person should know, a line each; `recordings`: their
  /// names by their numbers.
  [[nodiscard]] std::vector<std::string> notes(const std::string& interface,
                                               std::span<const std::string> recordings) const;
  /// ns that frames were recorded, without what is between stretches.
  [[nodiscard]] std::uint64_t covered() const { return covered_; }

 private:
  /// Of the frames of one recording.
  struct Range {
    std::uint32_t recording = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
  };
  /// Where time went back.
  struct Back {
    std::uint32_t recording = 0;
    std::uint64_t from = 0;
    std::uint64_t to = 0;
  };
  void begin(std::uint64_t ns, std::uint32_t recording);
  void go_on(std::uint64_t ns, bool may_pause);
  void note_order(const std::string& interface, std::span<const std::string> recordings,
                  std::vector<std::string>& out) const;

  std::vector<Range> ranges_;
  Stretch stretch_;
  std::uint64_t frames_ = 0;
  std::uint64_t last_ = 0;
  std::uint64_t covered_ = 0;
  std::uint64_t active_ = 0;   ///< ns between frames that were less than kPause apart
  std::uint64_t longest_ = 0;  ///< ns between two frames, without pauses
  std::uint64_t pauses_ = 0;
  std::uint64_t longest_pause_ = 0;
  std::uint64_t times_back_ = 0;
  Back first_back_;
};

}  // namespace mlcca::learn
