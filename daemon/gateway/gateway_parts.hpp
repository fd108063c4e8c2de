// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

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
#include "daemon/gateway/outside.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/reconciler.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reloads.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/adopted.hpp"
#include "daemon/gateway/requests/context.hpp"
#include "daemon/gateway/requests/replies.hpp"
#include "daemon/gateway/rollout.hpp"
#include "daemon/gateway/safeguards.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/gateway/user_names.hpp"
#include "daemon/options.hpp"
#include "daemon/store/history.hpp"

namespace mlcca {

/// All parts of a gateway, connected with each other. Each part gets what it uses from those above
/// it. What is needed in the other direction is a callback, which is set here and called only after
/// the start.
struct GatewayParts {
  GatewayParts(Options given, Outside around);
  GatewayParts(const GatewayParts&) = delete;
  GatewayParts& operator=(const GatewayParts&) = delete;
  GatewayParts(GatewayParts&&) = delete;
  GatewayParts& operator=(GatewayParts&&) = delete;
  ~GatewayParts() = default;

  /// One line for the service manager.
  [[nodiscard]] std::string summary() const;
  /// Reads the description that is to be in force: the file, or the text of a rollout.
  [[nodiscard]] ReadDescription reader() const;
  /// See Turn::on_commit().
  void on_commit(Turn::Committed committed);

  Options options;
  Outside outside;
  Scene scene;
  Heartbeat heartbeat{outside.control, outside.clock};
  std::function<void()> pulse = [this] { heartbeat.pulse(); };
  Patience patience{pulse, outside.threads ? Patience::kLongest : 0};
  DeliveryEvents deliveries{scene, outside.log, pulse, [this](core::AdmissionId id) {
                              return recorder.contents().admissions.find(id) != nullptr;
                            }};
  Recorder recorder{scene, outside.gates, outside.log, patience, pulse};
  CanForwarding forwarding{
      scene, outside.gates, outside.links, outside.log, std::move(outside.can_rules), pulse};
  Turn turn{{scene, outside.gates, outside.control, outside.log, deliveries, recorder, forwarding,
             pulse}};
  TagBindings tags{scene, outside.gates, outside.log, turn, recorder, outside.can, outside.clock};
  BusMonitor buses{scene, outside.gates, outside.log, turn, outside.clock};
  AuditLog audit{scene, outside.gates, outside.clock};
  DropReports drops{scene, outside.gates, outside.log, deliveries, audit, outside.clock, pulse};
  Modes modes{outside.control, outside.log, drops, audit, recorder};
  AuditKeeper audit_keeper{audit, modes, outside.log, patience, outside.clock};
  Carriers carriers;
  GatewayPresence presence{{scene, outside.control, carriers, outside.log, outside.clock}};
  ReportedSilences reported_silences{scene};
  DeliveryHealth delivery_health{scene,         outside.gates,    drops, forwarding, carriers,
                                 outside.clock, reported_silences};
  SilenceReports silences{outside.loop, scene,           outside.clock,    outside.gates,
                          deliveries,   delivery_health, reported_silences};
  GateEvents gate_events{
      {scene, outside.gates, outside.links, outside.log, silences, delivery_health, tags}};
  Admissions admissions{scene, recorder, outside.log, turn, tags, outside.clock};
  Meshes meshes;
  Quotas quotas;
  requests::AdmissionsOfOthers adopted{
      {scene, recorder, admissions, outside.gates, turn, tags, forwarding, deliveries, membership}};
  std::unique_ptr<Rollout> rollout;        ///< null unless the gateway is in a cluster
  std::unique_ptr<Membership> membership;  ///< null unless the gateway is in a cluster
  ChannelReports channels{scene, outside.gates, delivery_health, deliveries};
  ReportEstimates estimates{scene, outside.gates, forwarding, meshes};
  LocalEnds local_ends{outside.log, outside.clock};
  Endpoints endpoints{scene, outside.gates, local_ends};
  Safeguards safeguards;
  Reconciler reconciler;
  Reloads reloads;
  HealthReport health;
  Aside aside;
  Replies replies{aside, scene};
  UserNames users;
  std::optional<store::History> history;  ///< set by Start
  std::optional<Context> context;         ///< set by Start
  std::uint64_t started = 0;              ///< Unix time in seconds

 private:
  [[nodiscard]] std::unique_ptr<Rollout> make_rollout();
  [[nodiscard]] std::unique_ptr<Membership> make_membership();
};

}  // namespace mlcca
