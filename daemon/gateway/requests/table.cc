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
  /// See takes_away(); nothing: the request may let more pass.
  bool (*takes_away)(const Context&, const Request&) = nullptr;
};
template <class Request>
Row(Privilege, Trace, Response (*)(Context&, const Asker&, const Request&)) -> Row<Request>;
template <class Request>
Row(Privilege, Trace, Response (*)(Context&, const Asker&, const Request&),
    bool (*)(const Context&, const Request&)) -> Row<Request>;

template <class Request>
bool always(const Context& /*context*/, const Request& /*request*/) {
  return true;
}

bool enforces_now(const Context& context, const control::ModeRequest& request) {
  return request.mode == "enforce" && request.when_clean_ns == 0 && context.modes.is_audit();
}

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
    Row{Privilege::program, Trace::none, delay},
    Row{Privilege::anyone, Trace::none, subscriptions},
    Row{Privilege::program, Trace::history, subscribe},
    Row{Privilege::program, Trace::none, refusal},
    Row{Privilege::anyone, Trace::none, ping},
    Row{Privilege::program, Trace::none, presence},
    Row{Privilege::anyone, Trace::none, reservations},
    Row{Privilege::anyone, Trace::none, what_if},
    Row{Privilege::anyone, Trace::none, history},
    Row{Privilege::anyone, Trace::none, gate},
    Row{Privilege::anyone, Trace::none, audit},
    Row{Privilege::anyone, Trace::none, cluster},
    Row{Privilege::member, Trace::none, renew},
    Row{Privilege::member, Trace::history, admit},
    Row{Privilege::member, Trace::history, release, always},
    Row{Privilege::member, Trace::history, withdraw, always},
    Row{Privilege::member, Trace::history, reinstate},
    Row{Privilege::member, Trace::history, drain, always},
    Row{Privilege::member, Trace::history, join},
    Row{Privilege::member, Trace::history, mode, enforces_now},
    Row{Privilege::member, Trace::history_of_reload, reload},
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

Response handle(Context& context, const Asker& asker, const control::Request& request) {
  return std::visit([&](const auto& body) { return row_of(body).handler(context, asker, body); },
                    request.body);
}

}  // namespace mlcca::requests
