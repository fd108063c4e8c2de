// SPDX-License-Identifier: BSD-2-Clause
// The handlers: one for each request, each in a separate file.
#pragma once
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

Response status(Context& context, const Asker& asker, const control::StatusRequest& request);
Response networks(Context& context, const Asker& asker, const control::NetworksRequest& request);
Response channels(Context& context, const Asker& asker, const control::ChannelsRequest& request);
Response announce(Context& context, const Asker& asker, const control::AnnounceRequest& request);
Response query(Context& context, const Asker& asker, const control::Query& request);
Response admit(Context& context, const Asker& asker, const control::Admit& request);
Response release(Context& context, const Asker& asker, const control::ReleaseRequest& request);
Response explain(Context& context, const Asker& asker, const control::ExplainRequest& request);
Response monitor(Context& context, const Asker& asker, const control::MonitorRequest& request);
Response mode(Context& context, const Asker& asker, const control::ModeRequest& request);
Response reload(Context& context, const Asker& asker, const control::ReloadRequest& request);
Response renew(Context& context, const Asker& asker, const control::RenewRequest& request);
Response routes(Context& context, const Asker& asker, const control::RoutesRequest& request);
Response reservations(Context& context, const Asker& asker,
                      const control::ReservationsRequest& request);
Response what_if(Context& context, const Asker& asker, const control::WhatIfRequest& request);
Response history(Context& context, const Asker& asker, const control::HistoryRequest& request);
Response gate(Context& context, const Asker& asker, const control::GateRequest& request);
Response withdraw(Context& context, const Asker& asker, const control::WithdrawRequest& request);
Response audit(Context& context, const Asker& asker, const control::AuditRequest& request);
Response delay(Context& context, const Asker& asker, const control::DelayRequest& request);
Response transfers(Context& context, const Asker& asker, const control::TransfersRequest& request);
Response subscriptions(Context& context, const Asker& asker,
                       const control::SubscriptionsRequest& request);
Response subscribe(Context& context, const Asker& asker, const control::SubscribeRequest& request);
Response refusal(Context& context, const Asker& asker, const control::RefusalRequest& request);
Response ping(Context& context, const Asker& asker, const control::PingRequest& request);
Response presence(Context& context, const Asker& asker, const control::PresenceRequest& request);
Response rollout(Context& context, const Asker& asker, const control::RolloutRequest& request);
Response rollout_state(Context& context, const Asker& asker,
                       const control::RolloutStateRequest& request);
Response reinstate(Context& context, const Asker& asker, const control::ReinstateRequest& request);
Response cluster(Context& context, const Asker& asker, const control::ClusterRequest& request);
Response drain(Context& context, const Asker& asker, const control::DrainRequest& request);
Response join(Context& context, const Asker& asker, const control::JoinRequest& request);

}  // namespace mlcca::requests
