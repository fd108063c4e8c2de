// SPDX-License-Identifier: BSD-2-Clause
// The handlers: one for each request, each in a separate file. A handler gets the parts of the
// gateway that it uses, and no others, so a test needs only these to call it.
#pragma once
#include <cstdint>

#include "base/clock.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/requests/replies.hpp"
#include "daemon/gateway/requests/response.hpp"
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
class GateReader;
class GatewayPresence;
class HealthReport;
class LocalEnds;
class Membership;
class Meshes;
class Modes;
class Patience;
class PortFacts;
class Recorder;
class Reloads;
class ReportEstimates;
class TagBindings;
class Turn;
namespace store {
class History;
}

namespace requests {

// All references outlive every request and every slice of a reply. `membership` is null if the
// gateway is in no cluster.

struct NoParts {};
Response ping(const NoParts& parts, const Asker& asker, const control::PingRequest& request);
Response monitor(const NoParts& parts, const Asker& asker, const control::MonitorRequest& request);

// What is, and why:

struct StatusParts {
  const Options& options;
  const Scene& scene;
  const Modes& modes;
  const GateControl& control;
  const PortFacts& gates;
  const HealthReport& health;
  const DeliveryHealth& delivery_health;
  const Reloads& reloads;
  const Replies& replies;
  const std::uint64_t& started;  ///< when this daemon was started, seconds since 1970
};
Response status(const StatusParts& parts, const Asker& asker,
                const control::StatusRequest& request);

struct NetworksParts {
  const Scene& scene;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response networks(const NetworksParts& parts, const Asker& asker,
                  const control::NetworksRequest& request);

struct ChannelsParts {
  const Scene& scene;
  const ChannelReports& channels;
  const Admissions& admissions;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response channels(const ChannelsParts& parts, const Asker& asker,
                  const control::ChannelsRequest& request);
Response explain(const ChannelsParts& parts, const Asker& asker,
                 const control::ExplainRequest& request);

struct RoutesParts {
  const Scene& scene;
  const Meshes& meshes;
  const Endpoints& endpoints;
  CanForwarding& forwarding;
  const Clock& clock;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response routes(const RoutesParts& parts, const Asker& asker,
                const control::RoutesRequest& request);

struct ReservationsParts {
  const Scene& scene;
  const Admissions& admissions;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response reservations(const ReservationsParts& parts, const Asker& asker,
                      const control::ReservationsRequest& request);

struct WhatIfParts {
  const Scene& scene;
  const Replies& replies;
};
Response what_if(const WhatIfParts& parts, const Asker& asker,
                 const control::WhatIfRequest& request);

struct HistoryParts {
  const Scene& scene;
  store::History& history;
  Patience& patience;
};
Response history(const HistoryParts& parts, const Asker& asker,
                 const control::HistoryRequest& request);

struct GateParts {
  const Scene& scene;
  const GateReader& gates;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response gate(const GateParts& parts, const Asker& asker, const control::GateRequest& request);

struct AuditParts {
  const AuditLog& audit;
  const Modes& modes;
  const DeliveryHealth& delivery_health;
  const Replies& replies;
};
Response audit(const AuditParts& parts, const Asker& asker, const control::AuditRequest& request);

// Run-time admissions:

struct QueryParts {
  const Scene& scene;
  const Recorder& recorder;
  const DeliveryHealth& delivery_health;
  const ChannelReports& channels;
  Turn& turn;
  const Membership* membership;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response query(const QueryParts& parts, const Asker& asker, const control::Query& request);

/// An admission may wait for the store. It keeps a copy of these references meanwhile.
struct AdmitParts {
  const Scene& scene;
  Recorder& recorder;
  Admissions& admissions;
  GateDriver& gates;
  Turn& turn;
  TagBindings& tags;
  CanForwarding& forwarding;
  DeliveryEvents& deliveries;
  GateEvents& gate_events;
  const DeliveryHealth& delivery_health;
  EventLog& log;
  Membership* membership;
  const ChannelReports& channels;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response admit(const AdmitParts& parts, const Asker& asker, const control::Admit& request);
Response subscribe(const AdmitParts& parts, const Asker& asker,
                   const control::SubscribeRequest& request);

struct RenewParts {
  Admissions& admissions;
};
Response renew(const RenewParts& parts, const Asker& asker, const control::RenewRequest& request);

struct ReleaseParts {
  const Scene& scene;
  Admissions& admissions;
  Membership* membership;
};
Response release(const ReleaseParts& parts, const Asker& asker,
                 const control::ReleaseRequest& request);

// Programs of this gateway:

struct AnnounceParts {
  const Scene& scene;
  const ChannelReports& channels;
  const Endpoints& endpoints;
  LocalEnds& local_ends;
  const Membership* membership;
  const GateControl& control;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response announce(const AnnounceParts& parts, const Asker& asker,
                  const control::AnnounceRequest& request);

struct TransfersParts {
  const Scene& scene;
  Carriers& carriers;
  const Endpoints& endpoints;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response transfers(const TransfersParts& parts, const Asker& asker,
                   const control::TransfersRequest& request);

struct DelayParts {
  const Scene& scene;
  Carriers& carriers;
  const Endpoints& endpoints;
  DeliveryHealth& delivery_health;
  EventLog& log;
  const Clock& clock;
};
Response delay(const DelayParts& parts, const Asker& asker, const control::DelayRequest& request);

struct SubscriptionsParts {
  const Scene& scene;
  const Endpoints& endpoints;
  const Admissions& admissions;
  const Replies& replies;
};
Response subscriptions(const SubscriptionsParts& parts, const Asker& asker,
                       const control::SubscriptionsRequest& request);

struct RefusalParts {
  const Scene& scene;
  EventLog& log;
};
Response refusal(const RefusalParts& parts, const Asker& asker,
                 const control::RefusalRequest& request);

struct PresenceParts {
  const Scene& scene;
  GatewayPresence& presence;
};
Response presence(const PresenceParts& parts, const Asker& asker,
                  const control::PresenceRequest& request);

// Changes by an operator:

struct WithdrawParts {
  const Scene& scene;
  Turn& turn;
  Recorder& recorder;
  EventLog& log;
};
Response withdraw(const WithdrawParts& parts, const Asker& asker,
                  const control::WithdrawRequest& request);
Response reinstate(const WithdrawParts& parts, const Asker& asker,
                   const control::ReinstateRequest& request);

struct ModeParts {
  Modes& modes;
  AuditKeeper& audit_keeper;
  store::History& history;
};
Response mode(const ModeParts& parts, const Asker& asker, const control::ModeRequest& request);

struct ReloadParts {
  Reloads& reloads;
};
Response reload(const ReloadParts& parts, const Asker& asker,
                const control::ReloadRequest& request);

// The cluster of this gateway:

struct ClusterParts {
  const Scene& scene;
  const Membership* membership;
  const ReportEstimates& estimates;
  const Replies& replies;
};
Response cluster(const ClusterParts& parts, const Asker& asker,
                 const control::ClusterRequest& request);

struct DrainParts {
  const Scene& scene;
  EventLog& log;
  Membership* membership;
};
Response drain(const DrainParts& parts, const Asker& asker, const control::DrainRequest& request);
Response join(const DrainParts& parts, const Asker& asker, const control::JoinRequest& request);

struct RolloutParts {
  Membership* membership;
};
Response rollout(const RolloutParts& parts, const Asker& asker,
                 const control::RolloutRequest& request);
Response rollout_state(const RolloutParts& parts, const Asker& asker,
                       const control::RolloutStateRequest& request);

}  // namespace requests
}  // namespace mlcca
