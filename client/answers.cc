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
  std::string_view kind;  ///< kind of an event as in control.proto
  Meaning meaning;
  Cause cause;
};
constexpr std::array kKinds{
#define MLCCA_EVENT(identifier, name, message_id, verdict, tone, decides, reach, meaning, cause) \
  Named{name, Meaning::meaning, Cause::cause},
#define MLCCA_CLIENT_EVENT(name, tone, decides, meaning, cause) \
  Named{name, Meaning::meaning, Cause::cause},
#include "control/event_kinds.inc"
};

const Named* kind_of(const control::Event& event) {
  const auto* const known = std::ranges::find(kKinds, event.kind, &Named::kind);
  return known == kKinds.end() ? nullptr : known;
}

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
               .problem = from.problems.empty() ? "" : from.problems.front(),
               .route = from.route,
               .checks = {}};
  out.checks.reserve(from.rows.size());
  std::ranges::transform(from.rows, std::back_inserter(out.checks), check_of);
  return out;
}

State state_of(const std::vector<Delivery>& deliveries) {
  const auto granted = std::ranges::count_if(deliveries, &Delivery::granted);
  if (granted == 0) return State::refused;
  return granted == std::ssize(deliveries) ? State::granted : State::partly;
}

}  // namespace

void summarise(Answer& answer) {
  answer.state = state_of(answer.deliveries);
  const auto worst = std::ranges::find(answer.deliveries, false, &Delivery::granted);
  if (worst != answer.deliveries.end())
    answer.reason = worst->reason;
  else
    answer.reason =
        answer.deliveries.empty() ? "nobody is at the other end" : answer.deliveries[0].reason;
}

std::optional<Answer> answer_of(const control::Reply& reply) {
  Answer out;
  if (const auto* error = std::get_if<control::Error>(&reply.body)) {
    if (error->kind == control::ErrorKind::world) return std::nullopt;
    out.state = State::rejected;
    out.reason = error->message;
    return out;
  }
  const auto* channels = std::get_if<control::Channels>(&reply.body);
  if (channels == nullptr) return std::nullopt;
  out.deliveries.reserve(channels->channels.size());
  std::ranges::transform(channels->channels, std::back_inserter(out.deliveries), delivery_of);
  summarise(out);
  return out;
}

std::optional<Cause> said_further_on(const control::Event& event) {
  if (!event.publisher.empty() || event.network.empty()) return std::nullopt;
  if (event.kind == "refused") return Cause::refused;
  if (event.kind == "granted") return Cause::granted;
  return std::nullopt;
}

Meaning meaning_of(const control::Event& event) {
  const Named* const known = kind_of(event);
  return known == nullptr ? Meaning::happened : known->meaning;
}

Cause cause_of(const control::Event& event) {
  const Named* const known = kind_of(event);
  return known == nullptr ? Cause::other : known->cause;
}

}  // namespace mlcca::client
