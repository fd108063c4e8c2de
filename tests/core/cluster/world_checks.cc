// SPDX-License-Identifier: BSD-2-Clause
// What must be so in every state of a world.
#include <algorithm>

#include "mlcca/arithmetic.hpp"
#include "tests/core/cluster/fingerprint.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

std::string World::key_of(const Admission& admission) const {
  return keys_->reservation(kBus, admission.first, admission.second);
}

/// Sum of promises, and one forwarder.
void World::check() {
  std::set<std::size_t> on_bus;  // of which gateways; what one of them decides alone is its own
  std::size_t ways = 0;
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    for (const auto& [admission, gate] : hosts_[g].gates)
      if (on_wire(g, gate)) {
        if (scenario_->restores == 0 && store_.mod(key_of(admission)) == 0)
          broken_ = "what is still sent is not in the store any more";
        on_bus.insert(admission.first);
      }
    ways += in_gate(g, hosts_[g].ways) ? 1 : 0;
  }
  if (on_bus.size() > 1) broken_ = "two admissions are on a medium that carries one";
  if (ways > 1) broken_ = "two gateways carry the same";
  check_subscribers();
  check_views();
  if (rolls_out()) check_descriptions();
}

/// What is on the medium counts for every gateway that knows of it.
void World::check_views() {
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    if (!runs(g) || !hosts_[g].synced) continue;
    const View& view = hosts_[g].member->view();
    for (std::size_t other = 0; other < hosts_.size(); ++other)
      for (const auto& [admission, gate] : hosts_[other].gates) {
        if (admission.first == g || hosts_[g].gates.contains(admission)) continue;
        const auto key = key_of(admission);
        const bool known = store_.mod(key) != 0 && store_.mod(key) <= view.revision();
        if (known && on_wire(other, gate) && bytes_of(view.foreign(kBus).rates) == 0 &&
            !view.foreign(kBus).unreadable && scenario_->restores == 0)
          broken_ = "what another gateway still sends is not counted";
      }
  }
}

void World::recover() {
  if (!up_) up_ = true;
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    Host& host = hosts_[g];
    host.stalled = false;
    if (!host.member && scenario_->off_for_good) continue;
    if (!host.member) start(g);
    if (std::exchange(host.paused, false)) go_on(g);
    // What was drained comes back as a new process.
    if (host.drained) start(g);
    wants_[g] = 0;
  }
  late_.clear();
  // A rollout may wait, and be undone.
  const int waits = rolls_out() ? static_cast<int>(4 * scenario_->patience) + 12 : 0;
  const int until = now_ + 24 + waits;
  constexpr int most = 10'000;  // steps, also if no time passes
  int taken = 0;
  const auto run = [&](int end) {
    while (now_ < end && broken_.empty()) {
      if (++taken > most) broken_ = "it never comes to rest";
      const auto all = steps(false);
      const auto it =
          std::ranges::find_if(all, [](const Step& s) { return s.kind <= Step::Kind::read_all; });
      const auto rolls = std::ranges::find_if(all, [](const Step& s) {
        return s.kind == Step::Kind::judge || s.kind == Step::Kind::load;
      });
      if (rolls != all.end())
        take(*rolls);
      else
        take(it == all.end() ? Step{} : *it);
    }
  };
  run(until - 24);
  if (broken_.empty()) call_off_who_is_gone();
  run(until - 12);
  for (std::size_t g = 0; g < hosts_.size() && broken_.empty(); ++g)
    if (runs(g) && !is_removed(g) &&
        hosts_[g].member->standing(clock(g)) != Member::Standing::joined)
      broken_ = "a gateway is no member though all is well: " + hosts_[g].member->why_not(clock(g));
  if (!broken_.empty()) return;
  check_behalf();
  check_served();
  check_rollouts();
  forget_subscribers();
  for (const Host& host : hosts_)
    for (const auto& [id, what] : host.answers)
      if (what == 0) broken_ = "an admission has no answer";
  for (std::size_t g = 0; g < hosts_.size(); ++g)
    for (const std::uint64_t id : std::set(hosts_[g].held)) {
      if (!runs(g)) continue;
      if (made_for(g, id) != nullptr) continue;  // it ends with what it is made for
      close(g, {g, id});
      hosts_[g].held.erase(id);
      hosts_[g].member->release(id, clock(g));
      turn(g);
    }
  run(until);
  if (!broken_.empty()) return;
  if (std::ranges::all_of(hosts_, [](const Host& h) { return h.member.has_value(); }) &&
      std::ranges::any_of(store_.entries, [](const auto& e) {
        return e.first[0] == 'r' || e.first[0] == 'x' || e.first[0] == 'a';
      }))
    broken_ = "something that nobody wants is left in the store";
  const std::size_t asks = runs(1) && !is_removed(1) ? 1 : 0;
  if (!fits(asks) || !hosts_[asks].member->why_not(clock(asks)).empty())
    broken_ = "nothing can be had";
  const std::uint64_t id = hosts_[asks].next_id++;
  ask(asks, id, asks == 1 ? way_of(1) : std::vector<std::size_t>());
  turn(asks);
  run(until + 4);
  if (broken_.empty() && hosts_[asks].answers[id] != 1) broken_ = "a free medium is not granted";
  const auto carries = [](const Host& host) {
    return std::ranges::any_of(host.gates, [](const auto& one) { return one.second.open; });
  };
  if (broken_.empty() && scenario_->behalf && (!carries(hosts_[0]) || !carries(hosts_[1])))
    broken_ = "what is granted is not open at all gateways";
  if (broken_.empty() && scenario_->elect &&
      std::ranges::count_if(hosts_, [](const Host& h) { return h.ways.open; }) != 1)
    broken_ = "nobody carries, or two do";
}

std::pair<std::uint64_t, std::uint64_t> World::fingerprint() const {
  Fingerprint f;
  f(ordered_, objections_, cannots_, cancels_, refused_, objected_, over_.size(), was_open_[0]);
  f(now_, up_, down_since_, wants_, releases_, lates_, lost_, twice_, stalls_, pauses_, crashes_,
    fences_, replaces_, compactions_, outages_, restores_, refusals_, drains_, store_.revision,
    store_.entries.size());
  for (const auto& [key, entry] : store_.entries) f(key, entry.mod, entry.create, entry.value);
  for (const Host& h : hosts_) {
    f(h.drained, h.member.has_value(), h.process, h.paused, h.stalled, h.synced,
      store_.log.size() - h.seen, h.until, h.held, h.failed.size(), h.found, h.next_id, h.answers,
      h.journal, h.ways.open, h.ways.closed, h.former.has_value(), h.flight.has_value());
    for (std::size_t n = h.seen; n < store_.log.size(); ++n) f(store_.log[n]);
    for (const bool failed : h.failed) f(failed);
    if (rolls_out()) f(h.rollout);
    for (const auto& [key, gate] : h.gates) f(key, gate.open, gate.closed, gate.description);
    if (h.member) h.member->visit_state(f);
    if (h.former) f(*h.former);
    if (h.flight) f(h.flight->txn, h.flight->result);
    for (const auto& [origin, ok] : h.agreed) f(origin.gateway, origin.id, origin.asked, ok);
    for (const auto& [origin, id] : h.behalf) f(origin.gateway, origin.id, origin.asked, id);
    f(h.kept, h.asked_for, h.asked_again, h.replaces);
    for (const auto& [s, gate] : h.locals) f(s, gate.open, gate.closed);
  }
  for (const auto& [gateway, id] : made_) f(gateway, id);
  for (const auto& [former, now] : continued_) f(former.first, former.second, now.second);
  f(promised_, gone_);
  for (const Late& one : late_) f(one.gateway, one.process, one.txn);
  return f.value();
}

}  // namespace mlcca::core::cluster::test
