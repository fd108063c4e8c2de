// SPDX-License-Identifier: BSD-2-Clause
// Messages that wait in one queue of a gateway. docs/explanation/can-analysis.md derives the two
// bounds.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/can/interference.hpp"
#include "core/can/level.hpp"
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// The messages of a bus in the order of their priorities, with what is known of them so far.
struct Streams {
  std::span<const Message> messages;
  std::span<const Time> responses;  ///< kNever: not bounded
  std::span<const unsigned> bands;
  Interference interference;  ///< jitter: how late their frames are offered, as far as known
};

class SharedQueue {
 public:
  /// `end`: behind the lowest of its members and those of equal priority. `blocking`: what may
  /// block it (Overhead::blocking()).
  SharedQueue(const Streams& streams, const Overhead& overhead, std::vector<std::size_t> members,
              unsigned depth, std::size_t end, Time blocking);

  [[nodiscard]] std::span<const std::size_t> members() const { return members_; }
  /// Messages before this one matter to the queue.
  [[nodiscard]] std::size_t end() const { return end_; }

  /// Longest time from when all frames of an event of a member are queued to the start of the last
  /// one, `last_frame` ns long; nothing if it is not bounded. `band`: of the member.
  [[nodiscard]] std::optional<Time> wait(unsigned band, Time last_frame) const;

 private:
  /// Members in the order of their bands, as ranges of members_.
  struct Range {
    std::size_t first;
    std::size_t last;
  };
  struct Case;
  [[nodiscard]] Time others(const Case& c, Time until) const;
  [[nodiscard]] Time queued_by(const Case& c, Time arrival) const;
  [[nodiscard]] Time demand_of(Range range, Time until) const;
  [[nodiscard]] Share share_of(Range range) const;
  [[nodiscard]] std::optional<Time> longest_wait(const Case& c, Time last_frame) const;

  const Streams& streams_;
  const Overhead& overhead_;
  std::vector<std::size_t> members_;
  std::vector<Range> others_;  ///< streams before end_ that are no members
  unsigned depth_;
  std::size_t end_;
  Time blocking_;
  Time longest_ = 0;         ///< frame of all before end_
  Time longest_member_ = 0;  ///< frame of the members
};

}  // namespace mlcca::core::can
