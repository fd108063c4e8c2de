// SPDX-License-Identifier: BSD-2-Clause
// The local protocol of FAMOUSO's event channel handler (TCP, port 5005), the side of the handler:
// one connection is one channel, which its client subscribes or announces in the first 9 octets.
//
//   50 subject[8]                        subscribe
//   56 subject[8]                        announce
//   52 subject[8] length[4] data[length] an event, either way
//
// No answer is ever sent. A client ends its channel by closing the connection, or by anything that
// is no event.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace mlcca::relay {

class LocalSession {
 public:
  using Octets = std::span<const std::uint8_t>;
  using Event = std::vector<std::uint8_t>;

  enum class Role : std::uint8_t {
    unknown,  ///< the first 9 octets have not come
    subscriber,
    publisher,
    ended,  ///< close the connection; why() says why
  };

  /// Longest event that there is.
  static constexpr std::size_t kMostOctets = 65'535;
  /// Of events that wait for a subscriber that does not read: further ones are lost.
  static constexpr std::size_t kMostWaiting = 100'000;

  /// Takes what has come; events that a publisher sent are added to `events`. Its own channel
  /// counts: the subject in front of an event means nothing, as in FAMOUSO.
  void take(Octets octets, std::vector<Event>& events);

  /// Octets until it is known what the client wants; 0: it is. Take no more before, so that events
  /// that follow at once stay where they are until the channel is there.
  [[nodiscard]] std::size_t missing() const;

  /// An event for a subscriber. False: it is lost, since too much waits.
  bool send(Octets event);
  /// What waits to be written, and how much of it was.
  [[nodiscard]] Octets waiting() const { return Octets(out_).subspan(written_); }
  void written(std::size_t octets);

  [[nodiscard]] Role role() const { return role_; }
  [[nodiscard]] std::uint64_t subject() const { return subject_; }
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  /// Octets of a message that is not complete, for tests of its bound.
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
