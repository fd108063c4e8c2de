// SPDX-License-Identifier: BSD-2-Clause
// The gateway as a whole, and the order of its steps.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "control/messages.hpp"
#include "daemon/gateway/gateway_parts.hpp"
#include "daemon/gateway/periodic_jobs.hpp"
#include "daemon/gateway/start.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

/// Owns all parts of the gateway and calls them in the right order: at the start and stop, when the
/// world changes, for requests of clients, and once in each turn of the loop.
class Controller {
 public:
  Controller(Options options, Outside outside);
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  Controller(Controller&&) = delete;
  Controller& operator=(Controller&&) = delete;
  ~Controller() = default;

  /// Reads the description and the journal, keeps or closes the existing gates accordingly, and
  /// opens the gates. On failure every gate is closed. No other event source may be on the loop
  /// yet.
  std::optional<StartError> start() { return start_.run(); }
  /// Gives back what is reserved on shared networks. If the result is true, stop() may follow at
  /// once; otherwise the caller waits until may_stop() is true, which happens in bounded time.
  bool begin_stop();
  [[nodiscard]] bool may_stop() const { return !parts_.membership || parts_.membership->may_end(); }
  /// Lets the gates deny everything. They stay in the kernel.
  void stop();
  /// Reloads the description, as the request does. Errors are logged.
  void reload() { parts_.reloads.begin(); }
  /// Whether a thread reads a description. The process must then end without waiting for the
  /// thread.
  [[nodiscard]] bool is_reading() const {
    return parts_.outside.reading.busy() || start_.reads_for_ever();
  }

  // Changes of the world:

  void links_changed() { parts_.reconciler.links_changed(); }
  /// To be called when udev reports a change of an interface.
  void identities_changed() {
    if (parts_.outside.gates.needs_reconcile()) parts_.reconciler.reconcile();
  }
  /// To be called when GateControl::reports_fd() is readable.
  void gates_reported();

  // Clients:

  serve::Answer answer(const control::Request& request, const serve::Peer& peer);
  /// A connection has ended, so the leases of the admissions that it held begin to run.
  void session_closed(std::uint64_t session) {
    parts_.admissions.session_closed(session);
    parts_.local_ends.session_closed(session);
    parts_.carriers.session_closed(session);
    if (parts_.membership) parts_.membership->session_closed(session);
  }

  // Time:

  /// To be called once in each turn of the loop, after the handlers: decides again where links have
  /// changed, and commits what was granted to the disk.
  void act();
  /// The next time when act() is to be called even if nothing happens, CLOCK_MONOTONIC in ns.
  [[nodiscard]] std::optional<std::uint64_t> due() const { return parts_.local_ends.due(); }
  /// Writes a heart-beat for the kernel. To be called at least every beat_interval().
  void beat();
  [[nodiscard]] std::uint64_t beat_interval() const {
    return parts_.outside.control.beat_interval();
  }
  /// To be called once a second: begins a round of everything that the gateway polls. Each work()
  /// does a part of it.
  void begin_round() { jobs_.begin_round(); }
  [[nodiscard]] bool has_work() const { return jobs_.has_work(); }
  void work() { jobs_.work(); }

  // Callbacks and reports:

  /// Sets the function that is called when everything that was answered with `held` is on disk, or
  /// with the error after which none of it is granted any more.
  void on_commit(Turn::Committed committed) { parts_.on_commit(std::move(committed)); }
  /// Sets the function that is called when the next slice of a delayed reply is ready.
  void on_slice(const Aside::Ready& ready);
  /// Sets the function that says whether a client has disconnected. No report is begun for it then.
  void on_begin(Aside::Gone gone) { parts_.aside.on_begin(std::move(gone)); }
  /// Replaces ForkBudget::kUsual. Fuzzing, which asks more often, needs this.
  void set_report_rates(ForkBudget::Rates rates) { parts_.aside.set_rates(rates); }
  /// Keeps the lock of lock_gates() as long as this object lives.
  void hold(Fd lock) { parts_.safeguards.keep(std::move(lock)); }
  /// One line for the service manager.
  [[nodiscard]] std::string summary() const { return parts_.summary(); }
  /// The description in force and the decisions about it.
  [[nodiscard]] const Scene& scene() const { return parts_.scene; }

 private:
  [[nodiscard]] control::Actor actor_of(const serve::Peer& peer);

  GatewayParts parts_;
  Start start_;
  PeriodicJobs jobs_;
};

}  // namespace mlcca
