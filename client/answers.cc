// SPDX-License-Identifier: BSD-2-Clause
#include "client/answers.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

namespace mlcca::client {
namespace {

struct Named {
  std::string_view kind;  ///< of an event in control.proto
  Cause cause;
};
/// "switched" is not here: it is degraded or upgraded.
constexpr std::array kCauses{
    Named{"granted", Cause::granted},     Named{"refused", Cause::refused},
    Named{"withdrawn", Cause::withdrawn}, Named{"released", Cause::withdrawn},
    Named{"excess", Cause::policed},      Named{"dropping", Cause::dropped},
    Named{"missing", Cause::missing},     Named{"restored", Cause::restored},
    Named{"lapsed", Cause::gates_closed}, Named{"stopped", Cause::gates_closed},
    Named{"mode", Cause::mode},           Named{"lagged", Cause::lagged},
};

Check check_of(const control::Row& row) {
  return {.where = row.where,
          .attribute = row.attribute,
          .unit = row.unit,
          .required = row.required,
          .provided = row.provided_known ? std::optional(row.provided) : std::nullopt,
          .fits = row.outcome == control::Outcome::fit,
          .margin = row.margin};
}

Delivery delivery_of(const control::Channel& from) {
  Delivery out{.granted = from.granted,
               .publisher = from.publisher,
               .from = from.from,
               .to = from.to,
               .reason = from.reason,
               .set = from.set,
               .trouble = from.troubles.empty() ? "" : from.troubles.front(),
               .route = from.route,
               .checks = {}};
  std::ranges::transform(from.rows, std::back_inserter(out.checks), check_of);
  return out;
}

State state_of(const std::vector<Delivery>& deliveries) {
  const auto granted = std::ranges::count_if(deliveries, &Delivery::granted);
  if (granted == 0) return State::refused;
  return granted == std::ssize(deliveries) ? State::granted : State::partly;
}

/// The worst set that is in use.
unsigned set_of(const Answer& answer) {
  unsigned worst = 0;
  for (const Delivery& d : answer.deliveries)
    if (d.granted) worst = std::max(worst, d.set);
  return worst;
}

Cause cause_of(const control::Event& event, const Answer& before, const Answer& after) {
  if (event.kind == "switched")
    return set_of(after) < set_of(before) ? Cause::upgraded : Cause::degraded;
  const auto* const known = std::ranges::find(kCauses, event.kind, &Named::kind);
  return known == kCauses.end() ? Cause::other : known->cause;
}

}  // namespace

Answer answer_of(const control::Reply& reply) {
  Answer out;
  const auto* channels = std::get_if<control::Channels>(&reply.body);
  if (channels == nullptr) {
    const auto* error = std::get_if<control::Error>(&reply.body);
    out.state = State::rejected;
    out.reason = error == nullptr ? "the daemon answered with something else" : error->message;
    return out;
  }
  std::ranges::transform(channels->channels, std::back_inserter(out.deliveries), delivery_of);
  out.state = state_of(out.deliveries);
  const auto worst = std::ranges::find(out.deliveries, false, &Delivery::granted);
  if (worst != out.deliveries.end())
    out.reason = worst->reason;
  else
    out.reason = out.deliveries.empty() ? "nobody is at the other end" : out.deliveries[0].reason;
  return out;
}

bool same_verdicts(const Answer& a, const Answer& b) {
  return a.state == b.state &&
         std::ranges::equal(a.deliveries, b.deliveries, [](const Delivery& x, const Delivery& y) {
           return x.granted == y.granted && x.set == y.set && x.publisher == y.publisher &&
                  x.from == y.from && x.to == y.to;
         });
}

bool changes_verdicts(const control::Event& event) {
  constexpr std::array<std::string_view, 6> kinds{"granted",  "refused",  "withdrawn",
                                                  "released", "switched", "reinstated"};
  return std::ranges::find(kinds, event.kind) != kinds.end();
}

Exception exception_of(const control::Event& event, const Answer& before, const Answer& after) {
  return {.cause = cause_of(event, before, after),
          .text = event.message,
          .silent = std::chrono::nanoseconds(event.silent_ns),
          .missing_events = event.missing,
          .answer = after};
}

}  // namespace mlcca::client
