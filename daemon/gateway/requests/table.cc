// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/table.hpp"

#include <tuple>
#include <variant>

#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {
namespace {

// What each handler gets of a gateway.

template <class Parts>
Parts parts_of(const Context& c) = delete;
template <>
NoParts parts_of(const Context& /*c*/) {
  return {};
}
template <>
StatusParts parts_of(const Context& c) {
  return {c.options, c.scene,           c.modes,   c.control, c.gates,
          c.health,  c.delivery_health, c.reloads, c.replies, c.started};
}
template <>
NetworksParts parts_of(const Context& c) {
  return {c.scene, c.estimates, c.replies};
}
template <>
ChannelsParts parts_of(const Context& c) {
  return {c.scene, c.channels, c.admissions, c.estimates, c.replies};
}
template <>
RoutesParts parts_of(const Context& c) {
  return {c.scene, c.meshes, c.endpoints, c.forwarding, c.clock, c.estimates, c.replies};
}
template <>
ReservationsParts parts_of(const Context& c) {
  return {c.scene, c.admissions, c.estimates, c.replies};
}
template <>
WhatIfParts parts_of(const Context& c) {
  return {c.scene, c.replies};
}
template <>
HistoryParts parts_of(const Context& c) {
  return {c.scene, c.history, c.patience};
}
template <>
GateParts parts_of(const Context& c) {
  return {c.scene, c.gates, c.estimates, c.replies};
}
template <>
AuditParts parts_of(const Context& c) {
  return {c.audit, c.modes, c.delivery_health, c.replies};
}
template <>
QueryParts parts_of(const Context& c) {
  return {c.scene, c.recorder,   c.delivery_health, c.channels,
          c.turn,  c.membership, c.estimates,       c.replies};
}
template <>
AdmitParts parts_of(const Context& c) {
  return {c.scene, c.recorder,   c.admissions, c.gates,       c.turn,
          c.tags,  c.forwarding, c.deliveries, c.gate_events, c.delivery_health,
          c.log,   c.membership, c.channels,   c.estimates,   c.replies};
}
template <>
RenewParts parts_of(const Context& c) {
  return {c.admissions};
}
template <>
ReleaseParts parts_of(const Context& c) {
  return {c.scene, c.admissions, c.membership};
}
template <>
AnnounceParts parts_of(const Context& c) {
  return {c.scene,      c.channels, c.endpoints, c.local_ends,
          c.membership, c.control,  c.estimates, c.replies};
}
template <>
TransfersParts parts_of(const Context& c) {
  return {c.scene, c.carriers, c.endpoints, c.estimates, c.replies};
}
template <>
DelayParts parts_of(const Context& c) {
  return {c.scene, c.carriers, c.endpoints, c.delivery_health, c.log, c.clock};
}
template <>
SubscriptionsParts parts_of(const Context& c) {
  return {c.scene, c.endpoints, c.admissions, c.replies};
}
template <>
RefusalParts parts_of(const Context& c) {
  return {c.scene, c.log};
}
template <>
PresenceParts parts_of(const Context& c) {
  return {c.scene, c.presence};
}
template <>
WithdrawParts parts_of(const Context& c) {
  return {c.scene, c.turn, c.recorder, c.log};
}
template <>
ModeParts parts_of(const Context& c) {
  return {c.modes, c.audit_keeper, c.history};
}
template <>
ReloadParts parts_of(const Context& c) {
  return {c.reloads};
}
template <>
ClusterParts parts_of(const Context& c) {
  return {c.scene, c.membership, c.estimates, c.replies};
}
template <>
DrainParts parts_of(const Context& c) {
  return {c.scene, c.log, c.membership};
}
template <>
RolloutParts parts_of(const Context& c) {
  return {c.membership};
}

template <class Request>
struct Row {
  Privilege privilege;
  Trace trace;
  Response (*answer)(const Context&, const Asker&, const Request&);
  /// See takes_away(); nothing: the request may let more pass.
  bool (*takes_away)(const Context&, const Request&) = nullptr;
};
template <class Request>
Row(Privilege, Trace, Response (*)(const Context&, const Asker&, const Request&)) -> Row<Request>;
template <class Request>
Row(Privilege, Trace, Response (*)(const Context&, const Asker&, const Request&),
    bool (*)(const Context&, const Request&)) -> Row<Request>;

template <class Handler>
struct Signature;
template <class P, class R>
struct Signature<Response (*)(const P&, const Asker&, const R&)> {
  using Parts = P;
  using Request = R;
};

/// Calls the handler with the parts that it uses.
template <auto handler, class S = Signature<decltype(handler)>>
Response by(const Context& context, const Asker& asker, const typename S::Request& request) {
  return handler(parts_of<typename S::Parts>(context), asker, request);
}

template <class Request>
bool always(const Context& /*context*/, const Request& /*request*/) {
  return true;
}

bool enforces_now(const Context& context, const control::ModeRequest& request) {
  return request.mode == "enforce" && request.when_clean_ns == 0 && context.modes.is_audit();
}

constexpr std::tuple kTable{
    Row{Privilege::anyone, Trace::none, by<status>},
    Row{Privilege::anyone, Trace::none, by<networks>},
    Row{Privilege::anyone, Trace::none, by<channels>},
    Row{Privilege::anyone, Trace::none, by<query>},
    Row{Privilege::anyone, Trace::none, by<explain>},
    Row{Privilege::anyone, Trace::none, by<announce>},
    Row{Privilege::anyone, Trace::none, by<monitor>},
    Row{Privilege::anyone, Trace::none, by<routes>},
    Row{Privilege::anyone, Trace::none, by<transfers>},
    Row{Privilege::program, Trace::none, by<delay>},
    Row{Privilege::anyone, Trace::none, by<subscriptions>},
    Row{Privilege::program, Trace::history, by<subscribe>},
    Row{Privilege::program, Trace::none, by<refusal>},
    Row{Privilege::anyone, Trace::none, by<ping>},
    Row{Privilege::program, Trace::none, by<presence>},
    Row{Privilege::anyone, Trace::none, by<reservations>},
    Row{Privilege::anyone, Trace::none, by<what_if>},
    Row{Privilege::anyone, Trace::none, by<history>},
    Row{Privilege::anyone, Trace::none, by<gate>},
    Row{Privilege::anyone, Trace::none, by<audit>},
    Row{Privilege::anyone, Trace::none, by<cluster>},
    Row{Privilege::member, Trace::none, by<renew>},
    Row{Privilege::member, Trace::history, by<admit>},
    Row{Privilege::member, Trace::history, by<release>, always},
    Row{Privilege::member, Trace::history, by<withdraw>, always},
    Row{Privilege::member, Trace::history, by<reinstate>},
    Row{Privilege::member, Trace::history, by<drain>, always},
    Row{Privilege::member, Trace::history, by<join>},
    Row{Privilege::member, Trace::history, by<mode>, enforces_now},
    Row{Privilege::member, Trace::history_of_reload, by<reload>},
    Row{Privilege::member, Trace::history, by<rollout>},
    Row{Privilege::anyone, Trace::none, by<rollout_state>},
};

/// std::get finds the only row of a type. It does not compile if there is none, or more than one.
template <class Request>
constexpr const Row<Request>& row_of(const Request& /*request*/) {
  return std::get<Row<Request>>(kTable);
}

}  // namespace

Privilege privilege_of(const control::Request& request) {
  return std::visit([](const auto& body) { return row_of(body).privilege; }, request.body);
}

Trace trace_of(const control::Request& request) {
  return std::visit([](const auto& body) { return row_of(body).trace; }, request.body);
}

std::uint64_t least_rows_of(const control::Request& request) {
  switch (trace_of(request)) {
    case Trace::none:
      break;
    case Trace::history:
      return 1;
    case Trace::history_of_reload:
      return Quotas::kRowsOfReload;
  }
  return 0;
}

bool takes_away(const Context& context, const control::Request& request) {
  return std::visit(
      [&](const auto& body) {
        const auto& row = row_of(body);
        return row.takes_away != nullptr && row.takes_away(context, body);
      },
      request.body);
}

Response handle(const Context& context, const Asker& asker, const control::Request& request) {
  return std::visit([&](const auto& body) { return row_of(body).answer(context, asker, body); },
                    request.body);
}

}  // namespace mlcca::requests
