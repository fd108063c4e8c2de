// SPDX-License-Identifier: BSD-2-Clause
// Where subscribers on this gateway receive what programs on it publish: no network is in between,
// and the daemon neither sees nor carries the events.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/gateway/event_log.hpp"

namespace mlcca {

/// Keeps the local addresses of subscribers, by channel and session.
class LocalEnds {
 public:
  /// The most subscribers of one channel. A publisher sends to each of them.
  static constexpr std::size_t kMostOfChannel = 64;
  /// The most of these that one user other than root may have.
  static constexpr std::size_t kMostOfUser = 32;

  /// `log` reports changed addresses to clients. It must outlive this object.
  explicit LocalEnds(EventLog& log) : log_(log) {}

  /// Adds the address of a subscriber until the session ends. A session has one address for each
  /// channel. The error: it is no valid address (see control::LocalAddress), or the channel or the
  /// user has too many.
  [[nodiscard]] Result<void> add(const core::EventChannel& channel, uid_t user,
                                 std::uint64_t session, const std::string& address);
  void session_closed(std::uint64_t session);
  /// An address, and the user that stated it.
  struct End {
    uid_t user = 0;
    std::string address;
    friend bool operator==(const End&, const End&) = default;
  };
  /// The addresses with their keys, which only programs may learn that are granted on this channel
  /// as publishers.
  [[nodiscard]] std::vector<End> all(core::Subject subject) const;

 private:
  struct Ends {
    std::string channel;
    std::map<std::uint64_t, End> by_session;
  };
  /// Why there is no room for one more; nullopt if there is.
  static std::optional<std::string> refusal(const std::string& channel, const Ends& ends,
                                            uid_t user);
  void report(core::Subject subject, const std::string& channel);

  EventLog& log_;
  std::map<core::Subject, Ends> ends_;
};

}  // namespace mlcca
