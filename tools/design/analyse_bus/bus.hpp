// SPDX-License-Identifier: BSD-2-Clause
// The CAN buses that analyse-bus analyses, from a table of messages or from the description of a
// system.
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

/// A message of a bus, with what check decides about it. The fields about check are for messages of
/// a description.
struct BusMessage {
  std::string name;
  std::uint32_t id = 0;  ///< identifier of 11 or 29 bits
  bool extended = false;
  bool tag_known = true;  ///< false: a broker assigns the identifier, and `id` is the smallest that
                          ///< it can be
  /// Payload of one frame in a table, of one event in a description; nullopt: it is not stated.
  std::optional<std::uint64_t> bytes;
  std::string where;  ///< "file:line" in the table or description
  std::string node;   ///< in a table, the node in whose FIFO its frames wait; may be empty
  std::optional<bool> granted;  ///< check grants or refuses it with certainty; nullopt: it does not
  Outcome outcome = Outcome::fit;  ///< what check decides
  bool held = true;                ///< check grants it, or would if the best cases were real
  bool present = true;             ///< it is on the bus if all best cases are real
  bool several = false;  ///< it goes to several places behind the bus, which are decided one by one
  core::Standing standing;  ///< whether it counts for others: core/design/bus_responses.hpp
  /// If it is granted: its response time (ns) beside everything else that is granted, and the part
  /// of that which arises on this bus (without the jitter from the way before).
  std::optional<std::uint64_t> granted_response;
  std::uint64_t granted_on_bus = 0;
  /// If it is refused because it would be late itself: the response time (ns) that check computed;
  /// kNever: there is no bound.
  std::optional<std::uint64_t> refused_response;
  std::uint64_t refused_jitter = 0;  ///< jitter from the way before, part of refused_response
  /// If it is refused because its queue is too short: the number of frames that would wait there.
  std::optional<std::uint32_t> refused_frames;
  /// It is refused because of this bus, possibly because another message would be late.
  bool in_vain = false;
  bool from_elsewhere = false;  ///< a gateway forwards it, so its jitter results from the way
                                ///< before
  std::string unbounded_on;     ///< the bus on the way before where it has no bound, so that its
                                ///< jitter here is kNever
  core::can::Message message;   ///< as analysed with all messages on all buses
  /// As analysed beside the messages that count; nullopt: there is no difference.
  std::optional<core::can::Message> beside;

  [[nodiscard]] const core::can::Message& sent() const { return beside ? *beside : message; }
};

/// A bus and its messages.
struct Bus {
  std::string network;               ///< empty: the bus is from a table
  std::vector<std::string> why_not;  ///< sentences; if there are any the bus is not analysed and
                                     ///< has no messages
  core::can::Assumptions assumptions;
  std::vector<BusMessage> messages;
  /// Sentences about values that are not stated although bounds depend on them, and about messages
  /// that are left out.
  std::vector<std::string> unknown;
  std::vector<std::string> left_out;
  /// Everything is known of the messages that count or are granted, so that the bounds hold.
  bool sure = true;
  core::Known known = core::Known::all;  ///< how much is known of what can be on the bus beside the
                                         ///< messages that count
  /// What the messages that are left out send here, if they do; nullopt if the description does not
  /// say enough.
  std::vector<std::optional<core::can::Message>> uncounted;
  std::vector<std::string> findings;  ///< what check finds on this bus, or would find with the
                                      ///< options
  bool has_options = false;  ///< options of the command line replace what the description states
};

/// What the command line states about a bus; it replaces what the description states.
struct BusOptions {
  std::string network;             ///< only this network; empty: all
  std::uint32_t bitrate = 0;       ///< bit/s; 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s; 0: not stated
  bool unknown_senders = false;
  std::optional<std::uint32_t> background;  ///< share of the bus time in 1e-6
  std::optional<core::FaultHypothesis> faults;
};

/// The buses, or the problems why there are none: lines with a place and what would be right.
struct Buses {
  std::vector<Bus> buses;
  std::vector<std::string> problems;
};

/// The highest bit rate of classic frames and of the arbitration phase of all others (ISO 11898-1).
inline constexpr std::uint32_t kMostArbitrationRate = 1'000'000;

/// Reads a table with the columns name, id, extended, bytes, period_us and optionally deadline_us,
/// jitter_us, fd, frames and node, in any order. `file` is its name in problems. The options must
/// state the bit rate.
Buses read_table(std::string_view text, const std::string& file, const BusOptions& options);

/// Reads the CAN networks of a description, with the publishers whose events cross them, as check
/// decides them. A bus that cannot be analysed has the reasons in `why_not`; if none can be, these
/// are problems.
Buses read_description(const std::string& file, const BusOptions& options);

/// Finds messages with the same name, and identifiers that several senders use: no bound holds for
/// those.
std::vector<std::string> problems_of(const std::vector<BusMessage>& messages,
                                     const std::string& network);

}  // namespace mlcca::tools::design
