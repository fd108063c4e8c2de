// SPDX-License-Identifier: BSD-2-Clause
// Reports that take long are made aside, by a child process: it has all that this process knew when
// it was forked, and leaves the reply, in slices, in memory that this process reads once it has
// ended (ADR 28).
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

  /// Children at once, of all users; a user has one, members of the control group and root together
  /// so many, and all other users so many, so that neither group keeps the other waiting. Further
  /// reports wait until one has ended and given back what it had.
  static constexpr std::size_t kAtOnce = 3;
  static constexpr std::size_t kOfStanding = 2;
  /// After that a child is killed, and a report that was made is given up, ns; one of which nothing
  /// is read, sooner.
  static constexpr std::uint64_t kLongest = 60'000'000'000;
  static constexpr std::uint64_t kUnread = 5'000'000'000;
  /// Bytes of a report; of those of one user that are made and not read yet; of those of all who
  /// are members, or are not. When that is too much the oldest go.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  /// Of one slice: the loop passes it on without reading it. Most have some KiB.
  static constexpr std::size_t kMostOfSlice = std::size_t{1} << 20;
  static constexpr std::size_t kKeptOfUser = std::size_t{64} << 20;
  static constexpr std::size_t kKept = std::size_t{128} << 20;
  /// Before each fork the loop does so many times what waits: who has connected is accepted, and
  /// what he asked for is answered.
  static constexpr unsigned kPasses = 2;

  explicit Aside(sd_event* loop, ForkBudget::Rates rates = ForkBudget::kUsual);
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  Aside(Aside&&) = delete;
  Aside& operator=(Aside&&) = delete;
  ~Aside();

  /// Called when the next slice for a session is ready.
  void on_ready(Ready ready) { ready_ = std::move(ready); }
  /// Asked before a report begins: whether the client of this session has hung up.
  void on_begin(Gone gone) { gone_ = std::move(gone); }
  void set_rates(ForkBudget::Rates rates) { budget_ = ForkBudget(rates); }
  /// `make` runs in the child, which begins in a later turn of the loop. Dropping what is returned
  /// ends it.
  /// The slices are encoded; without `may_slice` it is one, of at most
  /// control::Reply::kMaxBytesUnsliced bytes.
  serve::NextSlice ask(const serve::Peer& peer, Make make, bool may_slice = true);
  /// Ends what takes too long. Once a second.
  void poll();

 private:
  class Report;
  friend class Report;
  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  /// A child that was asked to end, until it has. Not moved: the source goes before its descriptor,
  /// of which other children have copies, so that epoll would not forget it by itself.
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
  std::vector<Report*> reports_;                 ///< waiting or running, in the order of asking
  std::map<uid_t, std::uint64_t> last_started_;  ///< of who asked lately: when
  std::list<Ended> ended_;                       ///< to be waited for
  Fd always_;     ///< can always be read: in line with the sockets when a report may begin
  Source work_;   ///< of always_
  Source timer_;  ///< on while reports wait for the budget
  unsigned passes_ = 0;
};

}  // namespace mlcca
