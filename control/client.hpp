// SPDX-License-Identifier: BSD-2-Clause
// The blocking other end of mlccad's control socket, for command line tools and tests.
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

/// How long the daemon may take to answer before it counts as stopped.
inline constexpr std::chrono::milliseconds kPatience{10'000};

class Client {
 public:
  /// Connects to the socket at `path`. The error says whether there is no daemon, no process
  /// listens or permission is missing.
  static Result<Client> connect(const std::string& path,
                                std::chrono::milliseconds patience = kPatience);

  /// Takes over a connected stream socket.
  explicit Client(Fd socket, std::chrono::milliseconds patience = kPatience);

  /// Sends the request under a fresh id (`request.id` is not used) and waits for its reply. Events
  /// that come in between are kept for next_event(). A refusal by the daemon is a reply with an
  /// Error body; a daemon that is lost or does not answer is an error.
  Result<Reply> call(Request request);

  /// Waits without limit for the next event of a monitor, or of admissions that are held; an error
  /// when the daemon goes away.
  Result<Event> next_event();

  /// The same, or nothing once file descriptor `other` can be read or has ended, and no event is
  /// there. What comes in there is the caller's to read. Negative: as next_event().
  Result<std::optional<Event>> next_event_unless(int other);

 private:
  Result<void> send(const std::string& bytes);
  /// The next reply, within the daemon's patience.
  Result<Reply> receive();
  /// Receives some bytes; false if none came in time.
  Result<bool> receive_bytes();
  [[nodiscard]] std::string no_answer() const;

  Fd socket_;  ///< gives up sending and receiving after patience_
  std::chrono::milliseconds patience_;
  std::uint64_t last_id_ = 0;
  Buffer received_;
  std::deque<Event> events_;
};

}  // namespace mlcca::control
