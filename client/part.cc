// SPDX-License-Identifier: BSD-2-Clause
#include "client/part.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "client/answers.hpp"

namespace mlcca::client {
namespace {

bool only_informs(const Exception& exception) {
  switch (exception.cause) {
    case Cause::policed:
    case Cause::dropped:
    case Cause::missing:
    case Cause::restored:
    case Cause::missed:
    case Cause::late:
    case Cause::mode:
    case Cause::other:
      return true;
    default:
      return false;
  }
}

const Delivery* same_delivery(const Answer& answer, const Delivery& d) {
  const auto found = std::ranges::find_if(answer.deliveries, [&](const Delivery& other) {
    return other.publisher == d.publisher && other.from == d.from && other.to == d.to;
  });
  return found == answer.deliveries.end() ? nullptr : &*found;
}

/// How the decision on a delivery has changed; nullopt if it has not.
std::optional<Cause> change_of(const Delivery* was, const Delivery& is) {
  const bool was_granted = was != nullptr && was->granted;
  if (is.granted != was_granted) return is.granted ? Cause::granted : Cause::withdrawn;
  if (!is.granted) return was == nullptr ? std::optional(Cause::refused) : std::nullopt;
  if (is.set == was->set) return std::nullopt;
  return is.set < was->set ? Cause::upgraded : Cause::degraded;
}

}  // namespace

void Channel::Part::note(Cause cause, std::string text, const control::Event* event) {
  if (waiting.size() >= kMostWaiting) {
    const auto least = std::ranges::find_if(waiting, only_informs);
    waiting.erase(least == waiting.end() ? waiting.begin() : least);
    lagged = true;
  }
  Exception exception;
  exception.cause = cause;
  exception.text = std::move(text);
  exception.answer = answer.get();
  if (event != nullptr) {
    exception.publisher = event->publisher;
    if (cause == Cause::network_down) exception.network = event->network_down;
    exception.silent = std::chrono::nanoseconds(event->silent_ns);
    exception.missing_events = event->missing;
    exception.frames = event->frames;
    exception.late_events = event->late;
    exception.longest = std::chrono::nanoseconds(event->longest_ns);
  }
  waiting.push_back(std::move(exception));
}

std::optional<Exception> Channel::Part::next() {
  if (std::exchange(lagged, false)) {
    Exception exception;
    exception.cause = Cause::lagged;
    exception.text = "exceptions were lost: process() is called too seldom";
    exception.answer = answer.get();
    return exception;
  }
  if (waiting.empty()) return std::nullopt;
  Exception next = std::move(waiting.front());
  waiting.pop_front();
  return next;
}

bool Channel::Part::concerns(const control::Event& event) const {
  // Before there is a delivery, only the channel is known.
  const auto known = answer.get();
  if (event.publisher.empty() || known->deliveries.empty()) return true;
  return std::ranges::any_of(known->deliveries, [&](const Delivery& d) {
    return d.publisher == event.publisher &&
           (d.to == event.network || d.from == event.network || event.network.empty());
  });
}

void Channel::Part::take(const std::shared_ptr<const Answer>& now) {
  const auto before = answer.get();
  answer = KeptAnswer(now);
  if (now->state == State::rejected) {
    if (before->state != State::rejected && before->state != State::unannounced)
      note(Cause::rejected, now->reason);
    return;
  }
  if (before->state == State::unannounced || before->state == State::no_daemon) return;
  for (const Delivery& d : now->deliveries)
    if (const auto cause = change_of(same_delivery(*before, d), d)) note(*cause, d.reason);
  for (const Delivery& d : before->deliveries)
    if (d.granted && same_delivery(*now, d) == nullptr)
      note(Cause::withdrawn,
           "there is no delivery of " + d.publisher + " to " + d.to + " any more");
}

bool Channel::Part::forget_problem(const control::Event& event) {
  const auto is_of = [&](const Delivery& d) {
    return !d.problem.empty() && (event.publisher.empty() || d.publisher == event.publisher) &&
           (event.network.empty() || d.to == event.network || d.from == event.network);
  };
  const auto before = answer.get();
  if (std::ranges::none_of(before->deliveries, is_of)) return false;
  const auto now = std::make_shared<Answer>(*before);
  for (Delivery& d : now->deliveries)
    if (is_of(d)) d.problem.clear();
  answer = KeptAnswer(now);
  return true;
}

bool Channel::Part::is_granted_here() const {
  const auto known = answer.get();
  return std::ranges::any_of(known->deliveries,
                             [](const Delivery& d) { return d.granted && d.from == d.to; });
}

void Channel::Part::withdraw(const control::Event& event) {
  const auto now = std::make_shared<Answer>(*answer.get());
  bool found = false;
  for (Delivery& d : now->deliveries) {
    if (!d.granted || (!event.publisher.empty() && d.publisher != event.publisher) ||
        (!event.network.empty() && d.to != event.network))
      continue;
    d.granted = false;
    d.reason = event.message;
    d.checks.clear();
    found = true;
  }
  if (!found) return;
  summarise(*now);
  answer = KeptAnswer(now);
  note(event.network_down.empty() ? Cause::withdrawn : Cause::network_down, event.message, &event);
}

}  // namespace mlcca::client
