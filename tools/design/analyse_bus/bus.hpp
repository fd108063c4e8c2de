// SPDX-License-Identifier: BSD-2-Clause
// A CAN bus that is analysed: from a table of messages or from the description of a system.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/can/message.hpp"
#include "core/design/bus_fate.hpp"
#include "core/design/bus_responses.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::tools::design {

struct BusMessage {
  std::string name;
  std::uint32_t id = 0;  ///< 11 or 29 bits
  bool extended = false;
  bool tag_known = true;  ///< otherwise a broker deals it: `id` is the least that it can be
  /// Payload of one frame; of a described publisher, of one event. Nothing: not stated.
  std::optional<std::uint64_t> bytes;
  std::string where;               ///< "file:line" of a table or a description
  std::string node;                ///< of a table: whose FIFO its frames wait in, or empty
  std::optional<bool> granted;     ///< of a description: whether check grants it, with certainty
  Outcome outcome = Outcome::fit;  ///< what check says of it
  bool held = true;         ///< of a description: check grants it, or would where best cases hold
  bool present = true;      ///< on the bus if all best cases hold
  bool several = false;     ///< for several places behind the bus, each decided for itself
  core::Standing standing;  ///< whether it counts: core/design/bus_responses.hpp
  /// Of what is granted: the response with what else is, and what of it is this bus's; ns.
  std::optional<std::uint64_t> granted_response;
  std::uint64_t granted_on_bus = 0;
  /// Of what check refuses for being late itself: the response that it found; ns, kNever: no bound.
  std::optional<std::uint64_t> refused_response;
  std::uint64_t refused_jitter = 0;  ///< that is in it
  /// Of what check refuses because its queue is too short: how many frames wait there.
  std::optional<std::uint32_t> refused_frames;
  /// check refuses it because of the bus, though it may be another message that would be late.
  bool in_vain = false;
  bool from_elsewhere = false;  ///< a gateway sends it on: its jitter follows from the way before
  std::string unbounded_on;     ///< bus on the way before where it is not bounded, so that its
                                ///< jitter here is kNever
  core::can::Message message;   ///< as it is with all messages on all buses
  /// As it is beside what counts; nothing: the same.
  std::optional<core::can::Message> beside;

  [[nodiscard]] const core::can::Message& sent() const { return beside ? *beside : message; }
};

struct Bus {
  std::string network;               ///< empty: from a table
  std::vector<std::string> why_not;  ///< it is not analysed, and has no messages: sentences
  core::can::Assumptions assumptions;
  std::vector<BusMessage> messages;
  /// What is not stated although bounds depend on it, and what is left out: sentences.
  std::vector<std::string> unknown;
  std::vector<std::string> left_out;
  /// Nothing is unknown of what counts, or of what is granted: bounds hold.
  bool sure = true;
  core::Known known = core::Known::all;  ///< of what can be there, beside the messages that count
  /// Of what is left out: what it sends here if it does; nothing where the description does not say
  /// enough.
  std::vector<std::optional<core::can::Message>> uncounted;
  std::vector<std::string> findings;  ///< what check says of this bus, or with its options would
  bool has_options = false;  ///< the command line states what the description does otherwise
};

/// What the command line states of a bus. It goes before what a description states.
struct BusOptions {
  std::string network;             ///< only this one; empty: all
  std::uint32_t bitrate = 0;       ///< bit/s, 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s, 0: not stated
  bool unknown_senders = false;
  std::optional<std::uint32_t> background;  ///< 1e-6 of the bus time
  std::optional<core::FaultHypothesis> faults;
};

/// Buses, or why there are none: each problem is a line that names a place and what would be right.
struct Buses {
  std::vector<Bus> buses;
  std::vector<std::string> problems;
};

/// ISO 11898-1: of classic frames, and of the arbitration of all others.
inline constexpr std::uint32_t kMostArbitrationRate = 1'000'000;

/// The messages of a table with the columns name, id, extended, bytes, period_us and, if wanted,
/// deadline_us, jitter_us, fd, frames and node, in any order. `file` stands for it in problems. The
/// bit rate must be stated.
Buses read_table(std::string_view text, const std::string& file, const BusOptions& options);

/// The CAN networks of a description, with the described publishers whose events cross them, as a
/// check of the description decides them. One that cannot be analysed says why; if none can, these
/// are problems.
Buses read_description(const std::string& file, const BusOptions& options);

/// Messages of one name, and those that several senders give one identifier: no bound holds for
/// these.
std::vector<std::string> problems_of(const std::vector<BusMessage>& messages,
                                     const std::string& network);

}  // namespace mlcca::tools::design
