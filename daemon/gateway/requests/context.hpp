// SPDX-License-Identifier: BSD-2-Clause
// The parts of a gateway from which the table of requests takes those that each handler uses.
#pragma once
#include <cstdint>

#include "base/clock.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

struct Options;
class Admissions;
class AuditKeeper;
class AuditLog;
class CanForwarding;
class Carriers;
class ChannelReports;
class DeliveryEvents;
class DeliveryHealth;
class Endpoints;
class EventLog;
class GateControl;
class GateDriver;
class GateEvents;
class GatewayPresence;
class HealthReport;
class LocalEnds;
class Membership;
class Meshes;
class Modes;
class Patience;
class Recorder;
class Reloads;
class Replies;
class ReportEstimates;
class TagBindings;
class Turn;
namespace store {
class History;
}

/// All references outlive every request and every slice of a reply.
struct Context {
  const Options& options;
  const Clock& clock;
  GateDriver& gates;
  GateControl& control;
  Scene& scene;
  EventLog& log;
  DeliveryEvents& deliveries;
  Turn& turn;
  Recorder& recorder;
  Admissions& admissions;
  TagBindings& tags;
  GateEvents& gate_events;
  const AuditLog& audit;
  AuditKeeper& audit_keeper;
  Modes& modes;
  DeliveryHealth& delivery_health;
  HealthReport& health;
  ChannelReports& channels;
  Endpoints& endpoints;
  Carriers& carriers;
  GatewayPresence& presence;
  LocalEnds& local_ends;
  CanForwarding& forwarding;
  Meshes& meshes;
  Reloads& reloads;
  const ReportEstimates& estimates;
  const Replies& replies;
  Patience& patience;
  store::History& history;
  Membership* membership;        ///< null: this gateway is in no cluster
  const std::uint64_t& started;  ///< when this daemon was started, seconds since 1970
};

}  // namespace mlcca
