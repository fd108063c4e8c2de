// SPDX-License-Identifier: BSD-2-Clause
// The handler's side of the local protocol of FAMOUSO's event channel handler (TCP, port 5005). One
// connection is one channel; its first 9 octets say whether the client subscribes or announces.
//
//   50 subject[8]                        subscribe
//   56 subject[8]                        announce
//   52 subject[8] length[4] data[length] an event, in either direction
//
// The protocol has no answers. A client ends its channel by closing the connection, or by sending
// anything that is not an event of its channel.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace mlcca::relay {

/// The protocol state of one connection, without the socket.
class LocalSession {
 public:
  using Octets = std::span<const std::uint8_t>;
  using Event = std::vector<std::uint8_t>;

  /// The role of the client, by its first message.
  enum class Role : std::uint8_t {
    unknown,  ///< the first 9 octets have not arrived
    subscriber,
    publisher,
    ended,  ///< the connection is to be closed; why() has the reason
  };

  /// The longest event in octets.
  static constexpr std::size_t kMostOctets = 65'535;
  /// Octets that wait for a subscriber that does not read; further events are lost.
  static constexpr std::size_t kMostWaiting = 100'000;

  /// Takes received octets and adds the events of a publisher to `events`. An event of another
  /// subject than the announced one ends the connection. FAMOUSO's own handler ignores the subject
  /// in front of an event, and sends it as one of the announced channel.
  void take(Octets octets, std::vector<Event>& events);

  /// Octets that are missing until the client's role is known; 0: it is known. Read no more than
  /// that before, so that events that follow stay in the socket until the channel exists.
  [[nodiscard]] std::size_t missing() const;

  /// Queues an event for a subscriber. Returns false if it is lost because too many octets wait.
  bool send(Octets event);
  /// The octets that wait to be written; written() removes those that were.
  [[nodiscard]] Octets waiting() const { return Octets(out_).subspan(written_); }
  void written(std::size_t octets);

  [[nodiscard]] Role role() const { return role_; }
  [[nodiscard]] std::uint64_t subject() const { return subject_; }
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  /// Octets of an incomplete message; for tests of the bound.
  [[nodiscard]] std::size_t kept() const { return in_.size(); }

 private:
  void end(std::string why);
  bool take_opening();
  bool take_event(std::vector<Event>& events);

  Role role_ = Role::unknown;
  std::uint64_t subject_ = 0;
  std::string why_;
  std::vector<std::uint8_t> in_;
  std::vector<std::uint8_t> out_;
  std::size_t written_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace mlcca::relay
