// SPDX-License-Identifier: BSD-2-Clause
// Who may make which request of the control protocol. This is written a second time here on
// purpose, so that a wrong row in the table of the daemon is seen. A request that is in none of the
// lists does not compile.
#pragma once
#include <concepts>
#include <variant>

#include "control/messages.hpp"

namespace mlcca::test {

enum class Who : std::uint8_t {
  anyone,   ///< any local user
  program,  ///< a program of a user that the description names for it
  member,   ///< root and the control group
};

template <class T, class... List>
concept OneOf = (std::same_as<T, List> || ...);

template <class T>
concept ForAnyone =
    OneOf<T, control::StatusRequest, control::NetworksRequest, control::ChannelsRequest,
          control::Query, control::ExplainRequest, control::MonitorRequest, control::RoutesRequest,
          control::ReservationsRequest, control::WhatIfRequest, control::HistoryRequest,
          control::GateRequest, control::AnnounceRequest, control::TransfersRequest,
          control::SubscriptionsRequest, control::AuditRequest, control::RolloutStateRequest,
          control::ClusterRequest, control::PingRequest>;
template <class T>
concept ForPrograms = OneOf<T, control::DelayRequest, control::SubscribeRequest,
                            control::RefusalRequest, control::PresenceRequest>;
template <class T>
concept ForMembers =
    OneOf<T, control::Admit, control::ReleaseRequest, control::ModeRequest, control::ReloadRequest,
          control::RenewRequest, control::WithdrawRequest, control::ReinstateRequest,
          control::RolloutRequest, control::DrainRequest, control::JoinRequest>;

constexpr Who who_may(const ForAnyone auto& /*request*/) { return Who::anyone; }
constexpr Who who_may(const ForPrograms auto& /*request*/) { return Who::program; }
constexpr Who who_may(const ForMembers auto& /*request*/) { return Who::member; }
inline Who who_may(const control::Request& request) {
  return std::visit([](const auto& body) { return who_may(body); }, request.body);
}

}  // namespace mlcca::test
