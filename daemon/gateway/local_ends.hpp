// SPDX-License-Identifier: BSD-2-Clause
// Where subscribers on this gateway receive what programs on it publish: no network is in between,
// and the daemon neither sees nor carries the events.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "core/model/system.hpp"
#include "daemon/gateway/event_log.hpp"

namespace mlcca {

/// Keeps the local addresses of subscribers, by channel and session.
class LocalEnds {
 public:
  /// The most subscribers of one channel. A publisher sends to each of them.
  static constexpr std::size_t kMostOfChannel = 64;
  /// The most of these that one user other than root may have with the same standing.
  static constexpr std::size_t kMostOfUser = 16;
  /// Who a subscriber is. Each has places that those before it in this list cannot take.
  enum class Standing : std::uint8_t {
    anyone,   ///< any program may take up the end
    stated,   ///< the end states which programs may take it up
    trusted,  ///< the program is of root, or of a member of the control group
  };
  /// The most subscribers of one channel whose standing is at most this.
  static constexpr std::size_t most_up_to(Standing standing) {
    if (standing == Standing::anyone) return kMostOfChannel / 2;
    return standing == Standing::stated ? kMostOfChannel - kMostOfChannel / 8 : kMostOfChannel;
  }

  /// How often a session may change its address of one channel: once in this time (ns), and so
  /// many times at once.
  static constexpr std::uint64_t kChange = 1'000'000'000;
  static constexpr std::uint64_t kChangesAtOnce = 4;
  /// How long (ns) changes of one channel are collected before the next one is reported.
  static constexpr std::uint64_t kReport = 100'000'000;

  /// `log` reports changed addresses to clients. Both must outlive this object.
  LocalEnds(EventLog& log, const Clock& clock) : log_(log), clock_(clock) {}

  /// The program that states an address.
  struct Program {
    uid_t user = 0;
    std::uint64_t session = 0;
    Standing standing = Standing::anyone;
  };
  /// Adds the valid address (see control::LocalAddress) of a subscriber until the session ends. A
  /// session has one address for each channel. Returns why there is no place for it, or why it
  /// replaces no former one now; nullopt: it is added.
  [[nodiscard]] std::optional<std::string> add(const core::EventChannel& channel,
                                               const Program& program, const std::string& address);
  void session_closed(std::uint64_t session);
  /// Reports changes that have waited for kReport. To be called in each turn, and when it is due.
  void report_waiting();
  /// When report_waiting() is due next, CLOCK_MONOTONIC in ns; nullopt: nothing waits.
  [[nodiscard]] std::optional<std::uint64_t> due() const;
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
  struct Place {
    End end;
    Standing standing = Standing::anyone;
    std::uint64_t changes_until = 0;  ///< when all that it has changed is forgotten
  };
  /// A report of a channel that was made less than kReport ago.
  struct Report {
    std::string channel;
    bool waits = false;  ///< there is something to report since
  };
  struct Ends {
    std::string channel;
    std::map<std::uint64_t, Place> by_session;
  };
  /// Why there is no room for one more; nullopt if there is.
  static std::optional<std::string> refusal(const std::string& channel, const Ends& ends,
                                            const Program& program);
  void report(core::Subject subject, const std::string& channel);
  void report_now(core::Subject subject, const std::string& channel);
  [[nodiscard]] bool may_change(Place& place) const;

  EventLog& log_;
  const Clock& clock_;
  std::map<core::Subject, Report> reports_;
  std::deque<std::pair<std::uint64_t, core::Subject>> due_;  ///< when each of them is kReport old
  std::map<core::Subject, Ends> ends_;
};

}  // namespace mlcca
