// SPDX-License-Identifier: BSD-2-Clause
// The waiting time in one queue of a gateway. docs/explanation/can-analysis.md ("The queue of a
// gateway") derives the two bounds.
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

/// The messages of a bus, highest priority first, with the intermediate results of the analysis.
struct Streams {
  std::span<const Message> messages;
  std::span<const Time> responses;  ///< ns, present bounds; kNever: not bounded
  std::span<const unsigned> bands;
  Interference interference;  ///< the same streams; jitter: latest offer of their frames, as far as
                              ///< known
};

/// Computes how long frames wait in one shared queue. It refers to `streams` and `overhead`, which
/// must outlive it.
class SharedQueue {
 public:
  /// `members`: indices of the messages in the queue. `depth`: FIFO of the controller. `end`: index
  /// behind the lowest-priority member and those of equal priority. `blocking`: see
  /// Overhead::blocking().
  SharedQueue(const Streams& streams, const Overhead& overhead, std::vector<std::size_t> members,
              unsigned depth, std::size_t end, Time blocking);

  [[nodiscard]] std::span<const std::size_t> members() const { return members_; }
  /// Only messages with smaller indices affect the queue.
  [[nodiscard]] std::size_t end() const { return end_; }

  /// The longest time (ns) from when all frames of a member's event are queued until its last
  /// frame, which takes `last_frame` ns, starts. Nullopt if not bounded. `band` is that of the
  /// member.
  [[nodiscard]] std::optional<Time> wait(unsigned band, Time last_frame) const;

 private:
  /// A range of indices; members_ is sorted by band.
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
  std::vector<Range> others_;  ///< ranges of streams before end_ that are not in the queue
  unsigned depth_;
  std::size_t end_;
  Time blocking_;
  Time longest_ = 0;         ///< ns, longest frame of all streams before end_
  Time longest_member_ = 0;  ///< ns, longest frame of the members
};

}  // namespace mlcca::core::can
