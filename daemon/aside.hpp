// SPDX-License-Identifier: BSD-2-Clause
// Reports that take long are made aside, by a child process: it has all that this process knew when
// it was forked, and sends the reply in slices through a pipe (ADR 28).
#pragma once
#include <sys/types.h>
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "control/buffer.hpp"
#include "control/messages.hpp"
#include "core/handle.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

class Aside {
 public:
  using Body = decltype(control::Reply::body);
  using Make = std::function<Body()>;
  using Ready = std::function<void(std::uint64_t session)>;

  /// Children at once, of all users; a user has one. Further reports wait until one of them ends.
  static constexpr std::size_t kAtOnce = 2;
  /// After that a child is killed, ns; one that waits for a client that does not read, sooner.
  static constexpr std::uint64_t kLongest = 60'000'000'000;
  static constexpr std::uint64_t kUnread = 5'000'000'000;

  explicit Aside(sd_event* loop) : loop_(loop) {}
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  Aside(Aside&&) = delete;
  Aside& operator=(Aside&&) = delete;
  ~Aside();

  /// Told when the next slice for a session can be had.
  void on_ready(Ready ready) { ready_ = std::move(ready); }
  /// `make` runs in the child. Dropping what is returned ends it.
  serve::NextSlice ask(const serve::Peer& peer, Make make);
  /// Ends what takes too long. Once a second.
  void look();

 private:
  class Report;
  friend class Report;
  void start_waiting();
  void ended(pid_t child);
  void reap();

  sd_event* loop_;
  Ready ready_;
  std::vector<Report*> reports_;                 ///< waiting or running, in the order of asking
  std::map<uid_t, std::uint64_t> last_started_;  ///< of who asked lately: when
  std::vector<pid_t> ended_;                     ///< to be waited for
};

}  // namespace mlcca
