// SPDX-License-Identifier: BSD-2-Clause
// The schedule of one CAN bus: its admitted messages, with the guarantee that each meets its
// deadline.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can/analysis.hpp"
#include "core/can/interference.hpp"
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// The messages of one CAN bus. add() accepts a message only if all deadlines hold then. It is a
/// value: copies are independent, so a decision can be tried on a copy or undone by remove().
class Schedule {
 public:
  explicit Schedule(Assumptions assumptions = {});

  /// A message whose deadline or queue cannot be guaranteed.
  struct Late {
    std::uint64_t key = 0;
    Time response = 0;  ///< ns from the nominal release; meaningless unless `bounded`
    bool bounded = false;
    Time deadline = 0;
    Time jitter = 0;           ///< ns, from the nominal release until its frames are queued here
    bool overflow = false;     ///< its queue may have to hold more frames than fit
    std::uint32_t queued = 0;  ///< frames that the queue would have to hold
    std::uint32_t length = 0;  ///< frames that the queue holds
    bool operator==(const Late&) const = default;
  };

  /// Adds the message and returns nullopt if all messages then meet their deadlines. Otherwise
  /// nothing changes, and a message that would be late is returned: the new one or an existing one.
  /// The key must be new.
  [[nodiscard]] std::optional<Late> add(const Message& message);

  /// Removes a message; afterwards the schedule equals one to which it was never added. An unknown
  /// key is ignored.
  void remove(std::uint64_t key);

  /// Adds messages that others send, without a condition. Their keys must be new. Those of them
  /// that are late with all present messages are "spared": they count as load, but add() and late()
  /// ignore that they are late.
  void put(std::span<const Message> messages);
  /// Ends the sparing of messages that are in time now.
  void review();
  [[nodiscard]] bool spares_any() const { return !spared_.empty(); }
  /// The spared messages with their present lateness, in the order of messages().
  [[nodiscard]] std::vector<Late> spared() const;

  [[nodiscard]] bool contains(std::uint64_t key) const { return find(key) != nullptr; }
  /// The message of that key, or null. Valid until the schedule changes.
  [[nodiscard]] const Message* find(std::uint64_t key) const;
  /// The present bound (ns, from the nominal release); kNever if it is unbounded or the key is
  /// unknown.
  [[nodiscard]] Time response(std::uint64_t key) const;

  /// Replaces the assumptions and returns all messages that are late under them; none is removed.
  /// If the bit rate changes, the caller must replace the transmission times of the messages.
  std::vector<Late> set_assumptions(Assumptions assumptions);
  /// All messages that are late and not spared, in the order of messages(). Empty unless
  /// set_assumptions() or put() has made some late.
  [[nodiscard]] std::vector<Late> late() const;

  /// Sorted by priority, then key.
  [[nodiscard]] std::span<const Message> messages() const { return messages_; }
  /// Load of the bus in 1e-6 of its time, background included.
  [[nodiscard]] std::uint64_t utilisation_ppm() const;
  [[nodiscard]] const Assumptions& assumptions() const { return assumptions_; }

  /// Compares messages and assumptions; everything else follows from these.
  bool operator==(const Schedule& other) const {
    return assumptions_ == other.assumptions_ && messages_ == other.messages_;
  }

 private:
  [[nodiscard]] std::size_t position_of(std::uint64_t key) const;
  [[nodiscard]] bool is_spared(const Message& message) const {
    return !spared_.empty() && std::ranges::binary_search(spared_, message.key);
  }
  [[nodiscard]] Late late_of(std::size_t at, const Response& response) const;
  [[nodiscard]] std::vector<Response> all_responses() const;
  std::optional<Late> check_alone(std::size_t added);
  std::optional<Late> check_coupled();
  void insert(std::size_t at, const Message& message);
  void erase(std::size_t at);
  void rebuild();

  Assumptions assumptions_;
  std::vector<Message> messages_;
  Interference interference_;  ///< streams of messages_, in the same order
  /// Per message a known lower bound of its response (ns), from which the next analysis starts; 0
  /// if nothing is known.
  std::vector<Time> at_least_;
  std::size_t coupled_ = 0;            ///< number of messages with is_coupled()
  bool settled_ = true;                ///< no message is late, except for spared ones
  std::vector<std::uint64_t> spared_;  ///< keys, sorted
};

}  // namespace mlcca::core::can
