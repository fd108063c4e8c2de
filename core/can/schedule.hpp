// SPDX-License-Identifier: BSD-2-Clause
// The messages that are admitted to one CAN bus. A value: copies are independent, so a decision is
// tried on a copy or taken back by remove().
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

class Schedule {
 public:
  explicit Schedule(Assumptions assumptions = {});

  /// A message that cannot be guaranteed.
  struct Late {
    std::uint64_t key = 0;
    Time response = 0;  ///< ns; says nothing unless `bounded`
    bool bounded = false;
    Time deadline = 0;
    Time jitter = 0;           ///< of the message: what was taken before this bus
    bool overflow = false;     ///< its queue may hold more frames than fit
    std::uint32_t queued = 0;  ///< frames that the queue would have to hold
    std::uint32_t length = 0;  ///< frames that it holds
    bool operator==(const Late&) const = default;
  };

  /// Adds the message if every message then meets its deadline. Otherwise nothing changes, and one
  /// that would be late is returned: the new one or one that is there. The key must be new.
  [[nodiscard]] std::optional<Late> add(const Message& message);

  /// Afterwards the schedule is as if the message had never been added. An unknown key is ignored.
  void remove(std::uint64_t key);

  /// Messages that others send, whether or not they are in time and whoever becomes late by them.
  /// Their keys must be new. Those of them that are late with all that is there now disturb like
  /// the others, and add() and late() do not look at whether they are in time: they are spared.
  void put(std::span<const Message> messages);
  /// Spared messages that are in time now are spared no more.
  void review();
  [[nodiscard]] bool spares_any() const { return !spared_.empty(); }
  /// As they would be late; in the order of messages().
  [[nodiscard]] std::vector<Late> spared() const;

  [[nodiscard]] bool contains(std::uint64_t key) const { return find(key) != nullptr; }
  /// Null if there is none. Valid until the schedule changes.
  [[nodiscard]] const Message* find(std::uint64_t key) const;
  /// The bound as of now, ns; kNever if it is not bounded or the key is unknown.
  [[nodiscard]] Time response(std::uint64_t key) const;

  /// Other assumptions from now on. Returns all that is late under them; nothing is removed. The
  /// messages stay as they are: with another bit rate their times are the caller's to replace.
  std::vector<Late> set_assumptions(Assumptions assumptions);
  /// All that is late now and not spared, in the order of messages(). Empty unless assumptions
  /// changed, or put() has made something late.
  [[nodiscard]] std::vector<Late> late() const;

  /// Sorted by priority, then key.
  [[nodiscard]] std::span<const Message> messages() const { return messages_; }
  /// 1e-6 of the bus time, background included.
  [[nodiscard]] std::uint64_t utilisation_ppm() const;
  [[nodiscard]] const Assumptions& assumptions() const { return assumptions_; }

  /// The same messages under the same assumptions; all else follows from these.
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
  Interference interference_;  ///< of messages_, in their order
  /// A response that each message is known not to be below, to start from. 0: nothing is known.
  std::vector<Time> at_least_;
  std::size_t coupled_ = 0;            ///< messages whose bounds depend on the bounds of others
  bool settled_ = true;                ///< nothing is late but what is spared
  std::vector<std::uint64_t> spared_;  ///< keys, sorted
};

}  // namespace mlcca::core::can
