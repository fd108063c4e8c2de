// SPDX-License-Identifier: BSD-2-Clause
// What is sent on a CAN bus and what else is assumed of the bus. All times in ns.
#pragma once
#include <cstdint>
#include <vector>

#include "core/can/frame.hpp"
#include "core/model/system.hpp"

namespace mlcca::core::can {

/// Message::queue of a node that always offers its highest-priority message first.
inline constexpr std::uint32_t kOwnQueue = 0xffffffff;
/// Message::sender of a message that waits for no other one of its sender.
inline constexpr std::uint32_t kNoSender = 0xffffffff;

/// A stream of events, each of one frame or several. Times of more than kLongestTime are not
/// analysed: a response is not bounded then, a longer period counts as that one.
struct Message {
  std::uint64_t key = 0;       ///< the caller's; unique on a bus
  std::uint32_t priority = 0;  ///< arbitration(): the smaller wins
  /// Of a frame, if not all frames have `priority`: FAMOUSO gives fragments another identifier than
  /// events that fit one frame. Smaller than `priority`: all have that.
  std::uint32_t lowest_priority = 0;
  std::uint32_t frames = 1;  ///< of one event, at least 1
  /// Of an event of several frames: all frames wait together, those of the next event with them, so
  /// that lower priorities block once. Otherwise a frame is offered only after the one before it
  /// was sent, of the event before too, and each is blocked once more. Without meaning for events
  /// of one frame, the next of which always waits, and in a shared queue, where frames wait in the
  /// order in which they came.
  bool back_to_back = false;
  Time transmission = 0;   ///< all frames of an event, at least `last_frame`
  Time longest_frame = 0;  ///< of these frames
  Time last_frame = 0;     ///< the frame that is sent last; the shortest, if that is not known
  Time period = 0;         ///< least time between the nominal releases of two events, not 0
  Time deadline = 0;       ///< from the nominal release; may exceed the period
  Time jitter = 0;         ///< from the nominal release to when all frames of an event are queued
  std::uint32_t queue = kOwnQueue;  ///< index into Assumptions::queues: frames wait in that queue
  /// Of an event of several frames: the sender offers the next frame no sooner than `least_pause`
  /// after the one before, and all its pauses together are at most `pauses`.
  Time least_pause = 0;
  Time pauses = 0;
  /// Events of messages with one sender come one after the other, in any order: the first frame of
  /// one is offered when the last frame of the one before was sent. The low 8 bits are the address
  /// that their frames have: nobody else may send with it.
  std::uint32_t sender = kNoSender;

  bool operator==(const Message&) const = default;
};

/// Bands that Linux's queueing discipline prio has at most.
inline constexpr unsigned kPrioBands = 16;

/// The queue of a gateway in front of this bus. With Queueing::fifo all frames wait in one FIFO.
/// With Queueing::priority a frame waits in its band (bands_of() in analysis.hpp), the first band
/// that is not empty is served, and a band is a FIFO. Behind it stands the FIFO of the controller:
/// what was handed to it, up to `fifo_depth` frames with the one that is being offered or sent, is
/// not overtaken.
struct Queue {
  Queueing queueing = Queueing::fifo;
  std::uint32_t fifo_depth = 1;
  std::uint32_t length = 10;    ///< frames; another one is lost
  unsigned bands = kPrioBands;  ///< of the queueing discipline, at least 1
  bool operator==(const Queue&) const = default;
};

/// What is taken for granted of a bus beside its messages.
struct Assumptions {
  Timing timing;
  bool fd_frames = false;        ///< FD frames may occur, so the longest frame is one of them
  bool xl_frames = false;        ///< CAN XL frames may occur
  bool unknown_senders = false;  ///< any frame, the longest of the bus, may block
  /// 1e-6 of the bus time that others take at any priority: in any time t they hold the bus for at
  /// most longest_frame() + background * t.
  std::uint32_t background = 0;
  FaultHypothesis faults;
  std::vector<Queue> queues;
  bool operator==(const Assumptions&) const = default;
};

}  // namespace mlcca::core::can
