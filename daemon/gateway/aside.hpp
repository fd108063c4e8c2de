// SPDX-License-Identifier: BSD-2-Clause
// Makes reports that take long in child processes (ADR 28). A child has everything that this
// process knew when it was forked. It leaves the reply, in slices, in a memory file that this
// process reads after the child has ended.
#pragma once
#include <sys/types.h>
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/fork_budget.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

class Aside {
 public:
  using Body = decltype(control::Reply::body);
  using Make = std::function<Body()>;
  using Ready = std::function<void(std::uint64_t session)>;
  using Gone = std::function<bool(std::uint64_t session)>;

  /// The most children that run at once: of all users, and of each of the two groups of users
  /// (members of the control group with root, and all others), so that neither group keeps the
  /// other waiting. A user has at most one. Further reports wait until a child has ended and was
  /// reaped.
  static constexpr std::size_t kAtOnce = 3;
  static constexpr std::size_t kOfStanding = 2;
  /// ns. A child that runs longer than kLongest is killed. A report that is not read completely
  /// within kLongest, or of which no slice is read for kUnread, is given up.
  static constexpr std::uint64_t kLongest = 60'000'000'000;
  static constexpr std::uint64_t kUnread = 5'000'000'000;
  /// Limits in bytes: kMostBytes for one report, kKeptOfUser for the unread reports of one user,
  /// kKept for those of one group of users. Where they are exceeded, the oldest reports fail.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  /// The largest slice. The loop passes it on without reading it; most slices have some KiB.
  static constexpr std::size_t kMostOfSlice = std::size_t{1} << 20;
  static constexpr std::size_t kKeptOfUser = std::size_t{64} << 20;
  static constexpr std::size_t kKept = std::size_t{128} << 20;
  /// Before each fork the loop runs this many times, so that clients that have connected are
  /// accepted and their requests are answered first.
  static constexpr unsigned kPasses = 2;

  explicit Aside(sd_event* loop, ForkBudget::Rates rates = ForkBudget::kUsual);
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  Aside(Aside&&) = delete;
  Aside& operator=(Aside&&) = delete;
  ~Aside();

  /// Sets the function that is called when the next slice for a session is ready.
  void on_ready(Ready ready) { ready_ = std::move(ready); }
  /// Sets the function that says, before a report begins, whether the client of this session has
  /// hung up.
  void on_begin(Gone gone) { gone_ = std::move(gone); }
  void set_rates(ForkBudget::Rates rates) { budget_ = ForkBudget(rates); }
  /// Orders a report. `make` runs in a child, which begins in a later turn of the loop. Dropping
  /// the result ends the child. The result gives one encoded slice at a time. Without `may_slice`
  /// there is one slice of at most control::Reply::kMaxBytesUnsliced bytes.
  serve::NextSlice ask(const serve::Peer& peer, Make make, bool may_slice = true);
  /// To be called once a second: ends what takes too long.
  void poll();

 private:
  class Report;
  friend class Report;
  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  /// A child that was killed and has not been waited for yet. Not movable, so that its event source
  /// is always removed before its descriptor is closed: other children have copies of the
  /// descriptor, so epoll would not forget it by itself.
  struct Ended {
    pid_t child = 0;
    serve::Turns::User user{};
    Fd process{};
    Source source{};
  };
  static int on_work(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_time(sd_event_source*, std::uint64_t, void* self) noexcept;
  static int on_end(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  [[nodiscard]] std::vector<serve::Turns::User> busy() const;
  [[nodiscard]] std::vector<Report*> waiting() const;
  Report* next(std::uint64_t now);
  void start_next();
  void plan();
  void ended(pid_t child, serve::Turns::User user);
  void make_room_beside(const Report& fresh);
  void reap();

  sd_event* loop_;
  ForkBudget budget_;
  Ready ready_;
  Gone gone_;
  std::vector<Report*> reports_;  ///< waiting, running or not read yet, in the order of asking
  std::map<uid_t, std::uint64_t> last_started_;  ///< by user: the latest start, ns
  std::list<Ended> ended_;                       ///< children to be waited for
  Fd always_;     ///< always readable: queues behind the sockets while a report may begin
  Source work_;   ///< the event source of always_
  Source timer_;  ///< enabled while reports wait for the fork budget
  unsigned passes_ = 0;
};

}  // namespace mlcca
