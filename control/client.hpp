// SPDX-License-Identifier: BSD-2-Clause
// A client of mlccad's control socket that blocks, for command-line tools and tests.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"

namespace mlcca::control {

/// How long the daemon may take to answer before it counts as not running.
inline constexpr std::chrono::milliseconds kPatience{10'000};

/// One connection to the daemon. Requests are answered in order; events are queued.
class Client {
 public:
  /// Connects to the socket at `path`. The error distinguishes: there is no socket, no process
  /// listens at it, or permission is missing.
  static Result<Client> connect(const std::string& path,
                                std::chrono::milliseconds patience = kPatience);

  /// Takes ownership of a connected stream socket.
  explicit Client(Fd socket, std::chrono::milliseconds patience = kPatience);

  /// Sends the request under a new id (`request.id` is ignored) and waits for its reply; slices of
  /// a long reply are joined. Events that arrive meanwhile are queued for next_event(). If the
  /// daemon refuses the request, that is a reply with an Error body; an Error result means that the
  /// daemon is gone or did not answer in time.
  Result<Reply> call(Request request);

  /// Waits, without a time limit, for the next event of a monitor or of admissions that this
  /// connection holds. An error when the daemon goes away.
  Result<Event> next_event();

  /// As next_event(), but returns nullopt as soon as no event is queued and descriptor `other` is
  /// readable or closed. The caller reads from `other`. A negative `other` is ignored.
  Result<std::optional<Event>> next_event_unless(int other);

 private:
  /// Sends all bytes; an error if the daemon takes longer than patience_.
  Result<void> send(const std::string& bytes);
  /// The next reply; an error if the daemon takes longer than patience_.
  Result<Reply> receive();
  /// Receives some bytes; false if none came within patience_.
  Result<bool> receive_bytes();
  [[nodiscard]] std::string no_answer() const;

  Fd socket_;  ///< has patience_ as its timeout for sending and receiving
  std::chrono::milliseconds patience_;
  std::uint64_t last_id_ = 0;
  Buffer received_;
  std::deque<Event> events_;
};

}  // namespace mlcca::control
