// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/admissions.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

#include "base/text.hpp"
#include "core/cluster/lease.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

constexpr auto kNobody = std::nullopt;

Vote no(std::string reason) { return {.ok = false, .hop = {}, .reason = std::move(reason)}; }

/// The vote of a gateway on an admission of ours, if it is on that very one.
const VoteOf* vote_of(const View& view, std::size_t voter, std::size_t self, std::uint64_t id) {
  const auto asked = view.records().asked.find({self, id});
  const auto vote = view.records().votes.find({voter, self, id});
  if (asked == view.records().asked.end() || vote == view.records().votes.end()) return nullptr;
  const auto& value = vote->second.value;
  return value && value->asked == asked->second.create ? &*value : nullptr;
}

bool is_there(const View& view, std::size_t gateway, Value now) {
  const Alive alive = view.alive(gateway, now);
  return !view.is_fenced(gateway) && alive != Alive::absent && alive != Alive::draining;
}

/// "gateway id", or "gateway id (for another gateway)", of the entry of a network that says who
/// took something last.
std::string taker_of(const Entry& entry) { return printable(entry.value, 256); }

/// SplitMix64: all bits depend on all bits of `n`.
std::uint64_t mixed(std::uint64_t n) {
  n += 0x9e3779b97f4a7c15;
  n = (n ^ (n >> 30U)) * 0xbf58476d1ce4e5b9;
  n = (n ^ (n >> 27U)) * 0x94d049bb133111eb;
  return n ^ (n >> 31U);
}

}  // namespace

bool Admissions::deciding(std::uint64_t id) const {
  return std::ranges::any_of(own_, [id](const auto& entry) {
    const State state = entry.second.state;
    return entry.first != id && (state == State::asked || state == State::decide);
  });
}

bool Admissions::granted(std::uint64_t id) const {
  const auto it = own_.find(id);
  return it != own_.end() && it->second.state == State::granted;
}

void Admissions::refuse(Own& own, Vote why, std::optional<std::size_t> by,
                        std::vector<Event>& events) {
  if (!own.answered)
    events.emplace_back(Refused{.id = own.wanted.id, .why = std::move(why), .by = by});
  own.answered = true;
}

void Admissions::withdraw(Own& own, Vote why, std::optional<std::size_t> by,
                          std::vector<Event>& events) {
  if (!own.withdrawn)
    events.emplace_back(Withdrawn{.id = own.wanted.id, .why = std::move(why), .by = by});
  own.withdrawn = true;
}

/// The store has nothing of it and will have nothing.
bool Admissions::nowhere_but_here(const Own& own) {
  return own.state == State::decide || (own.state == State::asked && !own.sent);
}

/// Nobody wants it any more, and nothing of it is open here.
void Admissions::give_up(Own& own, Value now) {
  own.given_up = true;
  if (own.state == State::prepared) own.state = State::erasing;
  if (own.state != State::opening && own.state != State::granted) return;
  if (own.wanted.footprint.gateways.empty())
    erase(own, now);
  else
    own.state = State::ending;
}

/// It was closed everywhere just now.
void Admissions::erase(Own& own, Value now) {
  own.state = State::erasing;
  own.erase_from = queues_empty_at(now);
}

void Admissions::reserve(Wanted wanted, const View& view, Value now, std::vector<Event>& events) {
  auto it = own_.find(wanted.id);
  const auto& parts = wanted.footprint.parts;
  if (it != own_.end() && it->second.state != State::decide) {
    events.emplace_back(
        Refused{.id = wanted.id, .why = no("its number is still in the store"), .by = kNobody});
    return;
  }
  if (parts.size() > kMostNetworks) {
    if (it != own_.end()) own_.erase(it);
    events.emplace_back(
        Refused{.id = wanted.id, .why = no("it takes of too many networks"), .by = kNobody});
    return;
  }
  if (it == own_.end()) it = own_.emplace(wanted.id, Own{.since = now}).first;
  Own& own = it->second;
  own.state = State::asked;
  own.versions.clear();
  for (const Part& part : parts)
    own.versions[part.network] = std::max(view.version(part.network), versions_[part.network]);
  own.wanted = std::move(wanted);
}

void Admissions::release(std::uint64_t id, Value now) {
  const auto it = own_.find(id);
  if (it == own_.end()) return;
  it->second.answered = true;
  if (nowhere_but_here(it->second))
    own_.erase(it);
  else
    give_up(it->second, now);
}

void Admissions::release_all(const std::string& why, Value now, std::vector<Event>& events) {
  for (Own& own : std::views::values(own_)) {
    refuse(own, no(why), kNobody, events);
    if (!nowhere_but_here(own)) give_up(own, now);
  }
  std::erase_if(own_, [](const auto& entry) { return nowhere_but_here(entry.second); });
}

void Admissions::withdraw_all(const std::string& why, Value now, std::vector<Event>& events) {
  for (Own& own : std::views::values(own_)) {
    if (own.state == State::granted) {
      withdraw(own, no(why), kNobody, events);
      continue;
    }
    refuse(own, no(why), kNobody, events);
    if (!nowhere_but_here(own)) give_up(own, now);
  }
  std::erase_if(own_, [](const auto& entry) { return nowhere_but_here(entry.second); });
}

void Admissions::find(const View& view, std::int64_t since, Value now, std::vector<Event>& events) {
  const Records& records = view.records();
  for (auto it = records.asked.lower_bound({self_, 0});
       it != records.asked.end() && it->first.first == self_; ++it) {
    const auto& [key, record] = *it;
    if (own_.contains(key.second)) continue;
    const bool granted = record.asked.stage == Stage::granted;
    Own own{.wanted = {.id = key.second,
                       .footprint = {.parts = {}, .gateways = record.asked.gateways},
                       .admission = record.asked.admission},
            .state = State::granted,
            .answered = true};
    if (record.asked.stage == Stage::prepared) own.state = State::erasing;
    if (record.asked.stage == Stage::ending || (granted && record.mod < since)) give_up(own, now);
    if (own.state == State::erasing) own.erase_from = queues_empty_at(now);
    if (own.state == State::granted)
      events.emplace_back(Found{.id = key.second, .admission = record.asked.admission});
    own_.emplace(key.second, std::move(own));
  }
  for (const auto& key : std::views::keys(records.reservations))
    if (key.gateway == self_ && !own_.contains(key.id))
      own_.emplace(key.id, Own{.wanted = {.id = key.id},
                               .state = State::erasing,
                               .answered = true,
                               .erase_from = queues_empty_at(now)});
}

void Admissions::lose(const std::string& why, std::vector<Event>& events) {
  for (Own& own : std::views::values(own_)) refuse(own, no(why), kNobody, events);
  own_.clear();
  versions_.clear();
}

void Admissions::on_reserved(Own& own, const Done& done, Value now, std::vector<Event>& events) {
  for (const Part& part : own.wanted.footprint.parts) versions_[part.network] = done.revision;
  if (!own.wanted.footprint.gateways.empty()) {
    own.state = State::prepared;
  } else {
    own.state = State::granted;
    own.opened = done.revision;
    if (!own.answered && !own.given_up)
      events.emplace_back(Reserved{.id = own.wanted.id, .revision = done.revision});
    own.answered = true;
  }
  if (own.given_up) give_up(own, now);
}

/// At random, so that it does not go on with those of other gateways that it has met.
Value Admissions::wait_of(const Own& own) const {
  Value most = first_wait_;
  for (unsigned n = 1; n < own.tries && most < kLongestWait; ++n) most *= 2;
  return mixed(mixed(mixed(seed_) ^ own.wanted.id) ^ own.tries) % (most + 1);
}

/// The latest of those who were quicker each time.
Vote Admissions::taken_meanwhile(const Own& own, const View& view) {
  Vote vote = no("taken by " + own.taken_by + " meanwhile: others were quicker " +
                 std::to_string(own.tries) + (own.tries == 1 ? " time" : " times"));
  vote.gateway = view.keys().gateway(own.taken_by.substr(0, own.taken_by.find(' ')));
  if (own.taken_on) vote.hop = Place{Place::Kind::network, *own.taken_on};
  return vote;
}

/// A network of it has another version than the one from which it was decided.
void Admissions::on_quicker(Own& own, const Done& done, const View& view, Value now,
                            std::vector<Event>& events) const {
  Conflict conflict{.id = own.wanted.id, .network = 0, .by = {}, .tries = ++own.tries};
  own.seen = 0;
  for (const auto& [network, version] : own.versions)
    for (const Entry& entry : done.read) {
      if (entry.key != view.keys().version(network) || entry.mod == version) continue;
      conflict.network = network;
      conflict.by = taker_of(entry);
      own.seen = std::max(own.seen, entry.mod);
    }
  own.taken_by = conflict.by;
  own.taken_on = conflict.network;
  own.again_at = add_saturating(now, wait_of(own));
  if (own.tries >= kMostTries || own.again_at >= add_saturating(own.since, kPatience)) {
    refuse(own, taken_meanwhile(own, view), kNobody, events);
    return;
  }
  own.state = State::decide;
  own.quicker = std::move(conflict);
  step_quicker(own, view, now, events);
}

/// The caller decides again when it can see why.
void Admissions::step_quicker(Own& own, const View& view, Value now, std::vector<Event>& events) {
  if (!own.quicker || view.revision() < own.seen || now < own.again_at) return;
  events.emplace_back(*std::exchange(own.quicker, std::nullopt));
}

/// True: it is forgotten, because it was not done and nobody waits for it.
bool Admissions::on_asked(Own& own, const Done& done, const View& view, Value now,
                          std::vector<Event>& events) {
  if (own.state != State::asked || done.fate == Done::Fate::unsure) return false;
  own.sent = false;
  if (done.fate == Done::Fate::done) {
    on_reserved(own, done, now, events);
    return false;
  }
  if (!own.given_up && done.fate == Done::Fate::conflict) on_quicker(own, done, view, now, events);
  if (!own.given_up && !own.answered) return false;
  own_.erase(done.work.id);
  return true;
}

void Admissions::on_done(const Done& done, const View& view, Value now,
                         std::vector<Event>& events) {
  const auto it = own_.find(done.work.id);
  if (it == own_.end()) return;
  Own& own = it->second;
  const bool is_done = done.fate == Done::Fate::done;
  switch (done.work.kind) {
    case Work::Kind::reserve:
      if (on_asked(own, done, view, now, events)) return;
      break;
    case Work::Kind::open:
      if (!is_done) return;
      own.state = State::opening;
      own.opened = done.revision;
      if (own.given_up) give_up(own, now);
      break;
    case Work::Kind::end:
      if (is_done) own.ended = done.revision;
      break;
    case Work::Kind::erase:
      if (is_done) own_.erase(it);
      break;
    default:
      break;
  }
  step(view, now, events);
}

/// What the gateways on the way say of it, and whether they are there.
void Admissions::step_votes(Own& own, const View& view, Value now,
                            std::vector<Event>& events) const {
  bool all_applied = true;
  for (const std::size_t gateway : own.wanted.footprint.gateways) {
    const VoteOf* vote = vote_of(view, gateway, self_, own.wanted.id);
    std::optional<Vote> objection;
    if (vote && !vote->vote.ok) objection = vote->vote;
    if (!vote && own.state != State::prepared)
      objection = no(view.keys().gateway_name(gateway) + " does not carry it any more");
    if (!is_there(view, gateway, now)) objection = no(view.absence(gateway, now));
    if (objection && own.state != State::granted) {
      refuse(own, std::move(*objection), gateway, events);
      give_up(own, now);
      return;
    }
    if (objection) withdraw(own, std::move(*objection), gateway, events);
    const auto& beat = view.records().members[gateway].beat;
    all_applied = all_applied && beat && beat->applied >= own.opened;
  }
  if (own.state != State::opening || !all_applied) return;
  own.state = State::granted;
  own.answered = true;
  events.emplace_back(Reserved{.id = own.wanted.id, .revision = own.opened});
}

/// The first gateway for whose vote it waits, or which has not opened what is granted. nullopt:
/// nothing was asked of others yet, or the view is not so far.
std::optional<std::size_t> Admissions::silent_gateway(const Own& own, const View& view) const {
  const bool is_asked = own.state == State::prepared || own.state == State::opening;
  if (!is_asked || !view.records().asked.contains({self_, own.wanted.id})) return std::nullopt;
  const auto is_silent = [&](std::size_t gateway) {
    const auto& beat = view.records().members[gateway].beat;
    return vote_of(view, gateway, self_, own.wanted.id) == nullptr ||
           (own.state == State::opening && (!beat || beat->applied < own.opened));
  };
  const auto& gateways = own.wanted.footprint.gateways;
  const auto first = std::ranges::find_if(gateways, is_silent);
  return first == gateways.end() ? std::nullopt : std::optional(*first);
}

/// Nobody has decided in time: says who has not, or what was in the way.
void Admissions::refuse_late(Own& own, const View& view, std::vector<Event>& events) const {
  if (const auto silent = silent_gateway(own, view))
    refuse(own, no(view.keys().gateway_name(*silent) + " does not answer"), silent, events);
  else if (own.state <= State::decide && own.tries != 0)
    refuse(own, taken_meanwhile(own, view), kNobody, events);
  else
    refuse(own, no("the store does not answer"), kNobody, events);
}

void Admissions::step(const View& view, Value now, std::vector<Event>& events) {
  for (auto it = own_.begin(); it != own_.end();) {
    Own& own = it->second;
    const bool waits = !own.answered && own.state <= State::opening;
    if (waits && now >= add_saturating(own.since, kPatience)) {
      refuse_late(own, view, events);
      if (nowhere_but_here(own)) {
        it = own_.erase(it);
        continue;
      }
      give_up(own, now);
    }
    if (own.state == State::decide) step_quicker(own, view, now, events);
    if (own.state >= State::prepared && own.state <= State::granted)
      step_votes(own, view, now, events);
    if (own.state == State::ending && own.ended != 0 &&
        std::ranges::all_of(own.wanted.footprint.gateways, [&](std::size_t gateway) {
          return view.surely_closed(gateway, own.ended, now);
        }))
      erase(own, now);
    ++it;
  }
}

Work Admissions::reservation(const Own& own, const View& view, const Codec& codec) const {
  const Keys& keys = view.keys();
  const Wanted& wanted = own.wanted;
  Work work{.kind = Work::Kind::reserve, .id = wanted.id};
  std::string name = keys.gateway_name(self_) + ' ' + std::to_string(wanted.id);
  if (wanted.made_for) name += " (for " + keys.gateway_name(*wanted.made_for) + ')';
  for (const Part& part : wanted.footprint.parts) {
    const std::string version = keys.version(part.network);
    work.compares.push_back({.key = version, .revision = own.versions.at(part.network)});
    work.reads.push_back(version);
    work.puts.push_back({.key = version, .value = name});
    work.puts.push_back({.key = keys.reservation(part.network, self_, wanted.id),
                         .value = codec.write(Taken{.channel = wanted.channel,
                                                    .publisher = wanted.publisher,
                                                    .part = part,
                                                    .through = wanted.footprint.gateways})});
  }
  work.compares.push_back({.key = keys.current(), .revision = view.records().current.mod});
  const bool alone = wanted.footprint.gateways.empty();
  work.puts.push_back(
      {.key = keys.asked(self_, wanted.id),
       .value = codec.write(RouteRequest{.stage = alone ? Stage::granted : Stage::prepared,
                                         .admission = wanted.admission,
                                         .gateways = wanted.footprint.gateways})});
  return work;
}

/// When all have agreed.
std::optional<Work> Admissions::opening(const Own& own, const View& view,
                                        const Codec& codec) const {
  const Keys& keys = view.keys();
  const Wanted& wanted = own.wanted;
  Work work{.kind = Work::Kind::open, .id = wanted.id};
  for (const std::size_t gateway : wanted.footprint.gateways) {
    const VoteOf* vote = vote_of(view, gateway, self_, wanted.id);
    if (!vote || !vote->vote.ok) return std::nullopt;
    work.compares.push_back({.key = keys.vote(gateway, self_, wanted.id),
                             .revision = view.records().votes.at({gateway, self_, wanted.id}).mod});
    // After a conflict the view must have the other vote before this is tried again.
    work.reads.push_back(keys.vote(gateway, self_, wanted.id));
  }
  work.puts.push_back({.key = keys.asked(self_, wanted.id),
                       .value = codec.write(RouteRequest{.stage = Stage::granted,
                                                         .admission = wanted.admission,
                                                         .gateways = wanted.footprint.gateways})});
  return work;
}

Work Admissions::ending(const Own& own, const View& view, const Codec& codec) const {
  return {
      .kind = Work::Kind::end,
      .id = own.wanted.id,
      .puts = {{.key = view.keys().asked(self_, own.wanted.id),
                .value = codec.write(RouteRequest{.stage = Stage::ending,
                                                  .admission = own.wanted.admission,
                                                  .gateways = own.wanted.footprint.gateways})}}};
}

/// All that the store has of it.
Work Admissions::erasure(const Own& own, const View& view) const {
  const Keys& keys = view.keys();
  const std::uint64_t id = own.wanted.id;
  Work work{.kind = Work::Kind::erase, .id = id};
  work.deletes.push_back(keys.asked(self_, id));
  for (const Part& part : own.wanted.footprint.parts)
    work.deletes.push_back(keys.reservation(part.network, self_, id));
  for (std::size_t network = 0; network < keys.networks(); ++network) {
    std::string key = keys.reservation(network, self_, id);
    if (view.records().reservations.contains({.network = network, .gateway = self_, .id = id}) &&
        std::ranges::find(work.deletes, key) == work.deletes.end())
      work.deletes.push_back(std::move(key));
  }
  return work;
}

std::optional<Work> Admissions::work_of(const Own& own, const View& view, const Codec& codec,
                                        bool may_take, Value now) const {
  switch (own.state) {
    case State::asked:
      return may_take && !own.sent ? std::optional(reservation(own, view, codec)) : std::nullopt;
    case State::prepared:
      return opening(own, view, codec);
    case State::ending:
      return own.ended == 0 ? std::optional(ending(own, view, codec)) : std::nullopt;
    case State::erasing:
      return now >= own.erase_from ? std::optional(erasure(own, view)) : std::nullopt;
    default:
      return std::nullopt;
  }
}

std::optional<Work> Admissions::next_work(const View& view, const Codec& codec, bool may_take,
                                          Value now) {
  for (Own& own : std::views::values(own_)) {
    auto work = work_of(own, view, codec, may_take, now);
    if (!work) continue;
    own.sent = own.sent || work->kind == Work::Kind::reserve;
    return work;
  }
  return std::nullopt;
}

std::optional<Value> Admissions::next_time(Value now) const {
  std::optional<Value> next;
  const auto at = [&](Value time) {
    if (time > now) next = next ? std::min(*next, time) : time;
  };
  for (const Own& own : std::views::values(own_)) {
    if (!own.answered && own.state <= State::opening) at(add_saturating(own.since, kPatience));
    if (own.state == State::decide) at(own.again_at);
    if (own.state == State::erasing) at(own.erase_from);
  }
  return next;
}

}  // namespace mlcca::core::cluster
