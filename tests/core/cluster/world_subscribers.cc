// SPDX-License-Identifier: BSD-2-Clause
// Subscribers at gateway 1 of a publisher at gateway 0, as the daemon has them: in its journal
// until they are released or the publisher is gone, and open as long as gateway 0 agrees to each of
// them.
#include <algorithm>

#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

bool World::serves(std::size_t g) const { return scenario_->subscribers != 0 && g == 1; }

/// Which subscriber that own request is for; nullopt: for none.
std::optional<int> World::subscriber_of(std::size_t g, std::uint64_t id) const {
  for (const auto& [subscriber, of] : hosts_[g].asked_for)
    if (of == id) return subscriber;
  return std::nullopt;
}

/// Further ones are wanted when the first ones are there.
bool World::is_all_agreed(std::size_t g) const {
  return std::ranges::all_of(hosts_[g].asked_for, [&](const auto& entry) {
    return hosts_[g].held.contains(entry.second);
  });
}

/// Refusals are of interest from then on: those of new requests are in other scenarios.
bool World::are_all_kept() const {
  const auto all = static_cast<std::size_t>(scenario_->subscribers);
  return hosts_.size() < 2 || hosts_[1].kept.size() == all;
}

/// Asks for the first one that was not asked for yet.
void World::want_subscriber(std::size_t g, std::uint64_t id) {
  for (int s = 0; s < scenario_->subscribers; ++s)
    if (!hosts_[g].kept.contains(s) && hosts_[g].asked_for.try_emplace(s, id).second) return;
}

void World::on_agreed(std::size_t g, std::uint64_t id) {
  const auto subscriber = subscriber_of(g, id);
  if (!subscriber) return;
  hosts_[g].kept.insert(*subscriber);
  promised_.insert(*subscriber);
}

void World::on_refused(std::size_t g, std::uint64_t id, bool final) {
  const auto subscriber = subscriber_of(g, id);
  if (!subscriber) return;
  if (final || scenario_->mutant == Mutant::ended_by_a_passing_refusal)
    hosts_[g].kept.erase(*subscriber);
}

/// The user does not want it any more.
void World::forget_subscriber(std::size_t g, std::uint64_t id) {
  const auto subscriber = subscriber_of(g, id);
  if (!subscriber) return;
  hosts_[g].kept.erase(*subscriber);
  promised_.erase(*subscriber);
}

/// The publisher is released: all that was made for its subscribers ends for good.
void World::end_publisher(std::size_t g) {
  Host& host = hosts_[g];
  gone_ = true;
  for (const std::uint64_t id : std::set(host.held)) {
    close(g, {g, id});
    host.held.erase(id);
    vote_as(g, id, false);
    host.member->release(id, clock(g));
  }
}

/// Opens what is agreed to, closes the rest, and asks again for that.
void World::follow_agreements(std::size_t g) {
  if (!serves(g)) return;
  Host& host = hosts_[g];
  const bool knows_publisher = std::ranges::any_of(
      host.gates, [](const auto& gate) { return gate.first.first == 0 && gate.second.open; });
  for (int s = 0; s < scenario_->subscribers; ++s) {
    const auto asked = host.asked_for.find(s);
    const bool held = asked != host.asked_for.end() && host.held.contains(asked->second);
    const bool served = scenario_->mutant == Mutant::served_without_a_vote
                            ? knows_publisher && host.kept.contains(s)
                            : held;
    Gate& gate = host.locals[s];
    if (served)
      gate.open = true;
    else
      close_gate(g, gate);
    const bool waits = asked != host.asked_for.end() && host.answers.contains(asked->second) &&
                       host.answers.at(asked->second) == 0;
    if (asked != host.asked_for.end() && !held && !waits) host.asked_for.erase(asked);
  }
  for (const int s : host.kept) {
    if (host.asked_for.contains(s) || host.asked_again == now_ ||
        !host.member->why_not(clock(g)).empty())
      continue;
    host.asked_again = now_;
    host.asked_for[s] = host.next_id;
    ask(g, host.next_id++, way_of(g));
  }
}

/// In every state.
void World::check_subscribers() {
  if (scenario_->subscribers == 0) return;
  const Host& host = hosts_[1];
  for (const auto& [s, gate] : host.locals) {
    const auto asked = host.asked_for.find(s);
    if (!in_gate(1, gate) || scenario_->restores != 0) continue;
    if (asked == host.asked_for.end() || !made_.contains({1, asked->second}) ||
        store_.mod(keys_->asked(1, asked->second)) == 0)
      broken_ = "a subscriber is served without the agreement of the gateway of its publisher";
  }
  for (const int s : promised_)
    if (!gone_ && !host.kept.contains(s))
      broken_ = "an admission has ended for a reason that passes";
}

/// When all is well.
void World::check_served() {
  const Host& host = hosts_[1];
  if (scenario_->subscribers == 0) return;
  if (gone_ && !host.kept.empty()) broken_ = "an admission outlives its publisher";
  const bool is_taken = std::ranges::any_of(hosts_, [&](const Host& other) {
    return &other != &host && &other != &hosts_[0] && !other.held.empty();
  });
  for (const int s : host.kept)
    if (!is_taken && !in_gate(1, host.locals.at(s)))
      broken_ = "a subscriber is not served again though the reason has passed";
}

/// Nobody wants anything any more, and there is a publisher.
void World::forget_subscribers() {
  for (Host& host : hosts_) host.kept.clear();
  promised_.clear();
  gone_ = false;
}

}  // namespace mlcca::core::cluster::test
