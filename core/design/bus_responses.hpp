// SPDX-License-Identifier: BSD-2-Clause
// Response times of messages on a bus together with everything that can be there at once: granted
// messages, those that may be granted at run time, and those that a publisher of that bus sends
// although they are refused (no gate is in between). What is certainly refused and comes from
// another network does not count, because a gate drops it.
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
  bool counted = true;    ///< it can be on the bus, so it affects the response times of others
  bool admitted = false;  ///< it is on the bus only if admission found all messages in time with it
  /// The longest jitter (ns) it can have if a delay on its route is unknown; 0: all delays are
  /// known.
  can::Time most_jitter = 0;
};

/// How completely the messages of a bus are known.
enum class Known : std::uint8_t {
  all,     ///< completely
  forms,   ///< except for jitters of up to Standing::most_jitter
  little,  ///< there may be other messages, or the same in other forms
};

/// A response time, and where the bound comes from.
struct BusResponse {
  can::Response response;
  /// The bound is the deadline (or the length of the queue), because admission grants nothing that
  /// exceeds it. The analysis has no smaller bound, since it assumes everything at once that may be
  /// granted, or does not know everything.
  bool by_admission = false;
};

/// The response times of all messages. Those that count are analysed together; each of the others
/// as if it were added alone, or if there are very many, as if all were added. If delays are
/// unknown, a message with such a delay has its stated jitter, and all others are analysed with the
/// longest jitter that it can have.
[[nodiscard]] std::vector<BusResponse> responses_beside(const can::Assumptions& assumptions,
                                                        std::span<const can::Message> messages,
                                                        std::span<const Standing> standing,
                                                        Known known);

/// How completely the messages of a bus are known.
[[nodiscard]] Known known_of(const InspectedBuses& buses, std::size_t network);
/// What is known of that message.
[[nodiscard]] Standing standing_of(const InspectedBuses& buses, const BusMessage& message);

/// The messages of a network that are described sufficiently, with their response times; empty if
/// the bus is not analysed.
[[nodiscard]] std::vector<SentMessage> sent_beside(const InspectedBuses& buses,
                                                   std::size_t network);

/// Shares of the time of a bus, in 1e-6.
struct BusLoad {
  std::uint64_t present = 0;  ///< if all best cases hold
  /// Everything that can be there, as if at once, but at most all of the time. Equal to `present`
  /// if nothing may be granted in the place of what is present.
  std::uint64_t at_most = 0;
};
/// A message and whether it is on the bus if all best cases hold.
struct BusLoadPart {
  can::Message message;
  bool present = true;
};
/// The load of messages that count.
[[nodiscard]] BusLoad load_of(const can::Assumptions& assumptions,
                              std::span<const BusLoadPart> messages);
/// The load of a network; nullopt if the bus is not analysed.
[[nodiscard]] std::optional<BusLoad> load_on(const InspectedBuses& buses, std::size_t network);

}  // namespace mlcca::core
