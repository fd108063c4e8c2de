// SPDX-License-Identifier: BSD-2-Clause
// The gateway as a whole: connects the parts of the daemon, and defines the order of their steps.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/aside.hpp"
#include "daemon/gateway/audit_keeper.hpp"
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/bus_monitor.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/described.hpp"
#include "daemon/gateway/drop_reports.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/gate_events.hpp"
#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/health_report.hpp"
#include "daemon/gateway/heartbeat.hpp"
#include "daemon/gateway/local_ends.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reloads.hpp"
#include "daemon/gateway/requests/context.hpp"
#include "daemon/gateway/rollout.hpp"
#include "daemon/gateway/rounds.hpp"
#include "daemon/gateway/safeguards.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/gateway/user_names.hpp"
#include "daemon/options.hpp"
#include "daemon/outside/background.hpp"
#include "daemon/outside/cluster_link.hpp"
#include "daemon/outside/description_texts.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"
#include "daemon/serve/server.hpp"
#include "daemon/store/disk.hpp"
#include "daemon/store/history.hpp"

namespace mlcca {

/// The interfaces of the daemon to everything outside it. All references must outlive the
/// Controller.
struct Outside {
  GateDriver& gates;
  GateControl& control;
  LinkMonitor& links;
  CanSender& can;
  const Clock& clock;
  store::Disk& disk;
  Background& reading;  ///< thread that reads descriptions
  EventLog& log;
  ReadDescription read;
  ReadText read_text;                 ///< null unless the gateway is in a cluster
  DescriptionTexts* texts = nullptr;  ///< null unless the gateway is in a cluster
  std::unique_ptr<net::CanRules> can_rules;
  sd_event* loop;  ///< loop of the link sources, and of reports that are made aside
  /// Operations that may hang (disk, description) run on a thread while heart-beats continue.
  bool threads = true;
  ClusterLink* cluster = nullptr;  ///< null unless the gateway reserves shared networks in a store
};

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
  std::optional<StartError> start();
  /// Gives back what is reserved on shared networks. If the result is true, stop() may follow at
  /// once; otherwise the caller waits until may_stop() is true, which happens in bounded time.
  bool begin_stop();
  [[nodiscard]] bool may_stop() const { return !membership_ || membership_->may_end(); }
  /// Lets the gates deny everything. They stay in the kernel.
  void stop();
  /// Reloads the description, as the request does. Errors are logged.
  void reload() { reloads_.begin(); }
  /// Whether a thread reads a description. The process must then end without waiting for the
  /// thread.
  [[nodiscard]] bool is_reading() const { return outside_.reading.busy() || reads_for_ever_; }

  // Changes of the world:

  void links_changed();
  /// To be called when udev reports a change of an interface.
  void identities_changed() {
    if (outside_.gates.needs_reconcile()) reconcile();
  }
  /// To be called when GateControl::reports_fd() is readable.
  void gates_reported();

  // Clients:

  serve::Answer answer(const control::Request& request, const serve::Peer& peer);
  /// A connection has ended, so the leases of the admissions that it held begin to run.
  void session_closed(std::uint64_t session) {
    admissions_.session_closed(session);
    local_ends_.session_closed(session);
    carriers_.session_closed(session);
    if (membership_) membership_->session_closed(session);
  }

  // Time:

  /// To be called once in each turn of the loop, after the handlers: decides again where links have
  /// changed, and commits what was granted to the disk.
  void act();
  /// Writes a heart-beat for the kernel. To be called at least every beat_interval().
  void beat();
  [[nodiscard]] std::uint64_t beat_interval() const { return outside_.control.beat_interval(); }
  /// To be called once a second: begins a round of everything that the gateway polls. Each work()
  /// does a part of it.
  void begin_round() { rounds_.begin(); }
  [[nodiscard]] bool has_work() const { return rounds_.under_way(); }
  void work() { rounds_.turn(); }

  // Callbacks and reports:

  /// Sets the function that is called when everything that was answered with `held` is on disk, or
  /// with the error after which none of it is granted any more.
  void on_commit(Turn::Committed committed);
  /// Sets the function that is called when the next slice of a delayed reply is ready.
  void on_slice(const Aside::Ready& ready);
  /// Sets the function that says whether a client has disconnected. No report is begun for it then.
  void on_begin(Aside::Gone gone) { aside_.on_begin(std::move(gone)); }
  /// Replaces ForkBudget::kUsual. Fuzzing, which asks more often, needs this.
  void set_report_rates(ForkBudget::Rates rates) { aside_.set_rates(rates); }
  /// Keeps the lock of lock_gates() as long as this object lives.
  void hold(Fd lock) { safeguards_.keep(std::move(lock)); }
  /// One line for the service manager.
  [[nodiscard]] std::string summary() const;
  /// The description in force and the decisions about it.
  [[nodiscard]] const Scene& scene() const { return scene_; }

 private:
  std::optional<StartError> begin_start();
  std::optional<StartError> read_what_was();
  std::optional<StartError> open_gates();
  Result<void> put_in_force(const DeliveryEvents::Granted& granted_before,
                            TagBindings::Known known);
  void reconcile();
  void put_graphs();
  void plan_rounds();
  void poll_surroundings();
  [[nodiscard]] std::unique_ptr<Rollout> make_rollout();
  [[nodiscard]] std::unique_ptr<Membership> make_membership();
  [[nodiscard]] ReadDescription reader() const;
  Result<void> forget_cap();
  void note_presence();
  bool repair_next();
  bool poll_next_bypass();
  bool write_some_history();
  [[nodiscard]] control::Actor actor_of(const serve::Peer& peer);

  Options options_;
  Outside outside_;
  Scene scene_;
  Heartbeat heartbeat_{outside_.control, outside_.clock};
  std::function<void()> pulse_ = [this] { heartbeat_.pulse(); };
  Patience patience_{pulse_, outside_.threads ? Patience::kLongest : 0};
  DeliveryEvents deliveries_{scene_, outside_.log, pulse_, [this](core::AdmissionId id) {
                               return recorder_.contents().admissions.find(id) != nullptr;
                             }};
  Recorder recorder_{scene_, outside_.gates, outside_.log, patience_, pulse_};
  CanForwarding forwarding_{
      scene_, outside_.gates, outside_.links, outside_.log, std::move(outside_.can_rules), pulse_};
  Turn turn_{{scene_, outside_.gates, outside_.control, outside_.log, deliveries_, recorder_,
              forwarding_, pulse_}};
  TagBindings tags_{scene_,    outside_.gates, outside_.log,  turn_,
                    recorder_, outside_.can,   outside_.clock};
  BusMonitor buses_{scene_, outside_.gates, outside_.log, turn_, outside_.clock};
  AuditLog audit_{scene_, outside_.gates, outside_.clock};
  DropReports drops_{scene_, outside_.gates, outside_.log, deliveries_,
                     audit_, outside_.clock, pulse_};
  Modes modes_{outside_.control, outside_.log, drops_, audit_, recorder_};
  AuditKeeper audit_keeper_{audit_, modes_, outside_.log, patience_, outside_.clock};
  Carriers carriers_;
  GatewayPresence presence_{{scene_, outside_.control, carriers_, outside_.log, outside_.clock}};
  ReportedSilences reported_silences_{scene_};
  DeliveryHealth delivery_health_{scene_,         outside_.gates,    drops_, forwarding_, carriers_,
                                  outside_.clock, reported_silences_};
  SilenceReports silences_{outside_.loop, scene_,           outside_.clock,    outside_.gates,
                           deliveries_,   delivery_health_, reported_silences_};
  GateEvents gate_events_{
      {scene_, outside_.gates, outside_.links, outside_.log, silences_, delivery_health_, tags_}};
  Admissions admissions_{scene_, recorder_, outside_.log, turn_, tags_, outside_.clock};
  std::set<std::size_t> changed_meshes_;  ///< indices of the networks whose links have changed
  Meshes meshes_;
  std::unique_ptr<Rollout> rollout_;        ///< null unless the gateway is in a cluster
  std::unique_ptr<Membership> membership_;  ///< null unless the gateway is in a cluster
  ChannelReports channels_{scene_,      outside_.gates, delivery_health_,
                           deliveries_, forwarding_,    meshes_};
  LocalEnds local_ends_{outside_.log};
  Endpoints endpoints_{scene_, outside_.gates, local_ends_};
  Safeguards safeguards_;
  Reloads reloads_;
  HealthReport health_;
  Aside aside_;
  Quotas quotas_;
  UserNames users_;
  Rounds rounds_{[this] { return outside_.clock.monotonic_ns(); }};
  int at_gate_ = 0;  ///< ifindex of the gate that a job of the rounds has handled last
  std::optional<store::History> history_;
  /// The latest round had more than one slice of history to write.
  bool writes_much_history_ = false;
  std::optional<Context> context_;  ///< set by start()
  bool reads_for_ever_ = false;
  std::uint64_t started_ = 0;  ///< Unix time in seconds
};

}  // namespace mlcca
