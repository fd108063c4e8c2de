// SPDX-License-Identifier: BSD-2-Clause
// How late messages can be on a bus, beside all that can be there at once: what is granted, what
// may be granted at run time, and what a publisher of that bus sends although it is refused, since
// no gate lies between the two. What is refused for sure and comes from another network is dropped
// by a gate before it reaches the bus.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can/analysis.hpp"
#include "core/can/message.hpp"
#include "core/design/inspect.hpp"

namespace mlcca::core {

/// What is known of a message beside its frames.
struct Standing {
  bool counted = true;    ///< it can be on the bus, and counts in the response times of others
  bool admitted = false;  ///< it is on the bus only if admission found it and all others in time
  /// If a delay on its way to the bus is not known: the longest jitter that it can have; 0: all are
  /// known.
  can::Time most_jitter = 0;
};

/// How much is known of what can be on a bus, beside its messages.
enum class Known : std::uint8_t {
  all,     ///< there is nothing else
  forms,   ///< nothing else but jitters of up to Standing::most_jitter
  little,  ///< there may be other messages, or others of them
};

struct BusResponse {
  can::Response response;
  /// The bound is the deadline (or the length of the queue): admission grants nothing that would
  /// exceed it. The analysis has no smaller bound, since it takes all that may be granted together,
  /// or does not know all of it.
  bool by_admission = false;
};

/// Of each message as it is beside those that count; of one that does not: as if it came beside
/// them. Of very many that do not at most that: as if all of them came. Where delays are not known,
/// the message with such a delay has the jitter that is stated, and all others are analysed beside
/// the longest one that it can have.
[[nodiscard]] std::vector<BusResponse> responses_beside(const can::Assumptions& assumptions,
                                                        std::span<const can::Message> messages,
                                                        std::span<const Standing> standing,
                                                        Known known);

[[nodiscard]] Known known_of(const InspectedBuses& buses, std::size_t network);
[[nodiscard]] Standing standing_of(const InspectedBuses& buses, const BusMessage& message);

/// The messages of a network of which the description says enough, as they are on the bus, or would
/// be. None where it is not analysed.
[[nodiscard]] std::vector<SentMessage> sent_beside(const InspectedBuses& buses,
                                                   std::size_t network);

/// Shares of the time of a bus, 1e-6.
struct BusLoad {
  std::uint64_t present = 0;  ///< what is there if all best cases hold
  /// Nothing may be granted in its place: `present`. Otherwise all that can be there, as if at
  /// once: at most the whole time.
  std::uint64_t at_most = 0;
};
struct BusLoadPart {
  can::Message message;
  bool present = true;
};
/// Of messages that count.
[[nodiscard]] BusLoad load_of(const can::Assumptions& assumptions,
                              std::span<const BusLoadPart> messages);
/// Nothing where the bus is not analysed.
[[nodiscard]] std::optional<BusLoad> load_on(const InspectedBuses& buses, std::size_t network);

}  // namespace mlcca::core
