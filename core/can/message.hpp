// SPDX-License-Identifier: BSD-2-Clause
// The input of the analysis: the messages of a CAN bus, and what else is assumed of it. All times
// are in ns.
#pragma once
#include <cstdint>
#include <vector>

#include "core/can/frame.hpp"
#include "core/model/system.hpp"

namespace mlcca::core::can {

/// Value of Message::queue for a node that always offers its highest-priority frame first.
inline constexpr std::uint32_t kOwnQueue = 0xffffffff;
/// Value of Message::sender for a message that does not wait for other messages of its sender.
inline constexpr std::uint32_t kNoSender = 0xffffffff;

/// A stream of events, each of one frame or several. Times above kLongestTime are not analysed: a
/// longer jitter or transmission makes the message unbounded, a longer period counts as
/// kLongestTime.
struct Message {
  std::uint64_t key = 0;       ///< chosen by the caller; unique on a bus
  std::uint32_t priority = 0;  ///< from arbitration(): the smaller number wins
  /// The lowest priority of its frames, if they differ: FAMOUSO gives fragments another identifier
  /// than events that fit one frame. A number smaller than `priority` means that all frames have
  /// `priority`.
  std::uint32_t lowest_priority = 0;
  std::uint32_t frames = 1;  ///< frames of one event, at least 1
  /// For events of several frames: whether all frames, and those of the next event, wait together,
  /// so that lower priorities block once per busy period. Otherwise each frame is offered after the
  /// one before was sent and is blocked once more. Has no effect for events of one frame, whose
  /// next event always waits, and in a shared queue, which keeps the order of arrival.
  bool back_to_back = false;
  Time transmission = 0;   ///< all frames of an event together, at least `last_frame`
  Time longest_frame = 0;  ///< the longest frame of an event
  Time last_frame = 0;     ///< the frame that is sent last; the shortest one if that is unknown
  Time period = 0;         ///< least time between nominal releases of two events, not 0
  Time deadline = 0;       ///< from the nominal release; may exceed the period
  Time jitter = 0;         ///< from the nominal release until all frames of an event are queued
  std::uint32_t queue = kOwnQueue;  ///< index into Assumptions::queues, or kOwnQueue
  /// For events of several frames: the sender offers a frame no sooner than `least_pause` after the
  /// one before; all pauses of an event together take at most `pauses`.
  Time least_pause = 0;
  Time pauses = 0;
  /// Messages with the same sender are sent one event at a time, in any order: an event's first
  /// frame is offered when the last frame of the one before was sent. The low 8 bits are the source
  /// address of the frames, which no other sender may use.
  std::uint32_t sender = kNoSender;

  bool operator==(const Message&) const = default;
};

/// The most bands of the queueing discipline prio of Linux.
inline constexpr unsigned kPrioBands = 16;

/// The queue of a gateway in front of this bus. With Queueing::fifo all frames wait in one FIFO.
/// With Queueing::priority a frame waits in the FIFO of its band (see bands_of() in analysis.hpp),
/// and the first band that is not empty is served. Behind it is the FIFO of the controller: up to
/// `fifo_depth` frames, including the one being offered or sent, that cannot be overtaken.
struct Queue {
  Queueing queueing = Queueing::fifo;
  std::uint32_t fifo_depth = 1;
  std::uint32_t length = 10;    ///< frames that it holds; further frames are lost
  unsigned bands = kPrioBands;  ///< bands of the queueing discipline, at least 1
  bool operator==(const Queue&) const = default;
};

/// What is assumed of a bus beside its messages.
struct Assumptions {
  Timing timing;
  bool fd_frames = false;        ///< FD frames may occur, also as the longest frame
  bool xl_frames = false;        ///< CAN XL frames may occur
  bool unknown_senders = false;  ///< frames of unknown senders may block, up to the longest of the
                                 ///< bus
  /// Bus time, in 1e-6, that others take at any priority: in any time t they hold the bus for at
  /// most longest_frame() + background * t.
  std::uint32_t background = 0;
  FaultHypothesis faults;
  std::vector<Queue> queues;
  bool operator==(const Assumptions&) const = default;
};

}  // namespace mlcca::core::can
