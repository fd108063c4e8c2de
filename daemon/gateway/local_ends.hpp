// SPDX-License-Identifier: BSD-2-Clause
// Where subscribers on the gateway receive what programs on it publish: no network is in between,
// and the daemon neither sees nor carries the events.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/gateway/event_log.hpp"

namespace mlcca {

class LocalEnds {
 public:
  /// Subscribers of one channel. A publisher sends to each.
  static constexpr std::size_t kMostOfChannel = 64;

  /// The log passes on to clients that a channel has other ones. It must outlive this.
  explicit LocalEnds(EventLog& log) : log_(log) {}

  /// Until the session ends. It has one address for each channel. Error: it is no address that the
  /// kernel gave to a socket, or the channel has too many.
  [[nodiscard]] Result<void> add(const core::EventChannel& channel, std::uint64_t session,
                                 const std::string& address);
  void session_closed(std::uint64_t session);
  [[nodiscard]] std::vector<std::string> addresses(core::Subject subject) const;

 private:
  struct Ends {
    std::string channel;
    std::map<std::uint64_t, std::string> by_session;
  };
  void report(core::Subject subject, const std::string& channel);

  EventLog& log_;
  std::map<core::Subject, Ends> ends_;
};

}  // namespace mlcca
