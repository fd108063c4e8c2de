// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/table.hpp"

#include <tuple>
#include <variant>

#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

template <class Request>
struct Row {
  Privilege privilege;
  Trace trace;
  Response (*handler)(Context&, const Asker&, const Request&);
};
template <class Request>
Row(Privilege, Trace, Response (*)(Context&, const Asker&, const Request&)) -> Row<Request>;

constexpr std::tuple kTable{
    Row{Privilege::anyone, Trace::none, status},
    Row{Privilege::anyone, Trace::none, networks},
    Row{Privilege::anyone, Trace::none, channels},
    Row{Privilege::anyone, Trace::none, query},
    Row{Privilege::anyone, Trace::none, explain},
    Row{Privilege::anyone, Trace::none, announce},
    Row{Privilege::anyone, Trace::none, monitor},
    Row{Privilege::anyone, Trace::none, routes},
    Row{Privilege::anyone, Trace::none, transfers},
    Row{Privilege::anyone, Trace::none, delay},
    Row{Privilege::anyone, Trace::none, subscriptions},
    Row{Privilege::anyone, Trace::history, subscribe},
    Row{Privilege::anyone, Trace::none, refusal},
    Row{Privilege::anyone, Trace::none, ping},
    Row{Privilege::anyone, Trace::none, presence},
    Row{Privilege::anyone, Trace::none, reservations},
    Row{Privilege::anyone, Trace::none, what_if},
    Row{Privilege::anyone, Trace::none, history},
    Row{Privilege::anyone, Trace::none, gate},
    Row{Privilege::anyone, Trace::none, audit},
    Row{Privilege::anyone, Trace::none, cluster},
    Row{Privilege::member, Trace::none, renew},
    Row{Privilege::member, Trace::history, admit},
    Row{Privilege::member, Trace::history, release},
    Row{Privilege::member, Trace::history, withdraw},
    Row{Privilege::member, Trace::history, reinstate},
    Row{Privilege::member, Trace::history, drain},
    Row{Privilege::member, Trace::history, join},
    Row{Privilege::member, Trace::history, mode},
    Row{Privilege::member, Trace::history, reload},
    Row{Privilege::member, Trace::history, rollout},
    Row{Privilege::anyone, Trace::none, rollout_state},
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
  return std::holds_alternative<control::ReloadRequest>(request.body) ? Quotas::kRowsOfReload : 1;
}

bool takes_away(const Context& context, const control::Request& request) {
  if (const auto* mode = std::get_if<control::ModeRequest>(&request.body))
    return mode->mode == "enforce" && mode->when_clean_ns == 0 && context.modes.is_audit();
  return std::holds_alternative<control::WithdrawRequest>(request.body) ||
         std::holds_alternative<control::ReleaseRequest>(request.body) ||
         std::holds_alternative<control::DrainRequest>(request.body);
}

Response handle(Context& context, const Asker& asker, const control::Request& request) {
  return std::visit([&](const auto& body) { return row_of(body).handler(context, asker, body); },
                    request.body);
}

}  // namespace mlcca::requests
