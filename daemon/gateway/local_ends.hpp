// SPDX-License-Identifier: BSD-2-Clause
// Where subscribers on the gateway receive what programs on it publish: no network is in between,
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

class LocalEnds {
 public:
  /// Subscribers of one channel. A publisher sends to each.
  static constexpr std::size_t kMostOfChannel = 64;
  /// Of these, of one user other than root.
  static constexpr std::size_t kMostOfUser = 32;

  /// The log passes on to clients that a channel has other ones. It must outlive this.
  explicit LocalEnds(EventLog& log) : log_(log) {}

  /// Until the session ends. It has one address for each channel. Error: it is none (see
  /// control::LocalAddress), or the channel or the user has too many.
  [[nodiscard]] Result<void> add(const core::EventChannel& channel, uid_t user,
                                 std::uint64_t session, const std::string& address);
  void session_closed(std::uint64_t session);
  /// With their keys: for programs alone that are granted there as publishers.
  [[nodiscard]] std::vector<std::string> addresses(core::Subject subject) const;

 private:
  struct End {
    uid_t user = 0;
    std::string address;
  };
  struct Ends {
    std::string channel;
    std::map<std::uint64_t, End> by_session;
  };
  /// Why there is no place for one more; nothing: there is.
  static std::optional<std::string> refusal(const std::string& channel, const Ends& ends,
                                            uid_t user);
  void report(core::Subject subject, const std::string& channel);

  EventLog& log_;
  std::map<core::Subject, Ends> ends_;
};

}  // namespace mlcca
