// SPDX-License-Identifier: BSD-2-Clause
// Divides the time of an interface into stretches. A stretch ends at a recording of another day,
// where a clock was set back, where parts are in the wrong order, and at a pause without any frame.
// Gaps across such places say nothing about a channel.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace mlcca::learn {

/// A stretch of time: by one clock, and between two pauses.
struct Stretch {
  std::uint32_t clock = 0;
  std::uint32_t part = 0;
  bool operator==(const Stretch&) const = default;
};

/// The stretches of one interface.
class Timeline {
 public:
  /// In ns: frames from several queues of a controller may be out of order by so much.
  static constexpr std::uint64_t kDisorder = 10'000'000;
  /// The shortest time without a frame that can be a pause, in ns.
  static constexpr std::uint64_t kPause = 1'000'000'000;
  /// A pause is so many times as long as the longest other time without a frame.
  static constexpr std::uint64_t kFarLonger = 10;

  /// No CAN bus can carry two frames within so short a time, in ns: at 1 Mbit/s a frame takes 47
  /// us, and the arbitration of an FD frame 30 us.
  static constexpr std::uint64_t kTooClose = 20'000;

  /// Takes the time of a frame in the recording with that number. Returns the stretch of the frame.
  Stretch take(std::uint64_t ns, std::uint32_t recording);

  /// The time of the first frame of the first recording, the time of the latest frame, and the
  /// clock of the latter.
  [[nodiscard]] std::uint64_t first() const { return ranges_.empty() ? 0 : ranges_.front().first; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  [[nodiscard]] std::uint32_t clock() const { return stretch_.clock; }
  /// The number of frames less than kTooClose after the one before.
  [[nodiscard]] std::uint64_t too_close() const { return too_close_; }
  /// Remarks for a person about the times of `interface`, a line each; `recordings` are the names
  /// of recordings by number.
  [[nodiscard]] std::vector<std::string> notes(const std::string& interface,
                                               std::span<const std::string> recordings) const;
  /// The time in ns that was recorded, without the time between stretches.
  [[nodiscard]] std::uint64_t covered() const { return covered_; }
  /// Whether that is long enough to state what came in a second of `events` events: a second, or a
  /// tenth of it with many events.
  [[nodiscard]] bool tells_rate(std::uint64_t events) const {
    constexpr std::uint64_t second = 1'000'000'000;
    constexpr std::uint64_t many = 33;
    return covered_ >= second || (covered_ >= second / 10 && events >= many);
  }

 private:
  /// The times of the frames of one recording.
  struct Range {
    std::uint32_t recording = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
  };
  /// A place where time goes back.
  struct Back {
    std::uint32_t recording = 0;
    std::uint64_t from = 0;
    std::uint64_t to = 0;
  };
  void begin(std::uint64_t ns, std::uint32_t recording);
  /// How many times as long as the longest other time without a frame a pause must be now; 0: there
  /// was too little traffic to say.
  [[nodiscard]] std::uint64_t times_longer() const;
  /// `times`: see times_longer().
  void go_on(std::uint64_t ns, std::uint64_t times);
  void note_order(const std::string& interface, std::span<const std::string> recordings,
                  std::vector<std::string>& out) const;

  std::vector<Range> ranges_;
  Stretch stretch_;
  std::uint64_t frames_ = 0;
  std::uint64_t last_ = 0;
  std::uint64_t covered_ = 0;
  std::uint64_t active_ = 0;   ///< ns between frames less than kPause apart
  std::uint64_t longest_ = 0;  ///< ns between two frames, without pauses
  std::uint64_t too_close_ = 0;
  std::uint64_t pauses_ = 0;
  std::uint64_t longest_pause_ = 0;
  std::uint64_t times_back_ = 0;
  Back first_back_;
};

}  // namespace mlcca::learn
