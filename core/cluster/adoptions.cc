// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/adoptions.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

namespace mlcca::core::cluster {
namespace {

/// The most deletes of one transaction.
constexpr std::size_t kMostDeletes = 64;
/// The most votes of one transaction. After a conflict, the store returns as many entries.
constexpr std::size_t kMostVotes = 8;
static_assert(kMostVotes < kMostPuts);

/// What was reserved for an admission on all networks, and who has to agree to it.
Footprint taken_for(const View& view, const Records::AskedKey& key, const RouteRequest& asked) {
  Footprint footprint{.parts = {}, .gateways = asked.gateways};
  const auto& reservations = view.records().reservations;
  for (std::size_t n = 0; n < view.keys().networks(); ++n) {
    const auto it = reservations.find({.network = n, .gateway = key.first, .id = key.second});
    if (it == reservations.end() || !it->second.taken) continue;
    footprint.parts.push_back(it->second.taken->part);
  }
  return footprint;
}

}  // namespace

/// The admission if it needs the agreement of this gateway and is not ending or dead; null
/// otherwise.
const AskedRecord* Adoptions::live(const View& view, const Records::AskedKey& key) const {
  const auto it = view.records().asked.find(key);
  if (it == view.records().asked.end() || key.first == self_) return nullptr;
  const AskedRecord& record = it->second;
  const bool needs_us =
      std::ranges::find(record.asked.gateways, self_) != record.asked.gateways.end();
  const bool dead = record.mod < view.records().members[key.first].fence;
  return needs_us && !dead && record.asked.stage != Stage::ending ? &record : nullptr;
}

void Adoptions::take_up(const Records::AskedKey& key, View& view, std::vector<Event>& events) {
  const AskedRecord* record = live(view, key);
  const auto it = adopted_.find(key);
  if (it != adopted_.end() && (record == nullptr || record->create != it->second.asked)) {
    events.emplace_back(
        Ended{.origin = {.gateway = key.first, .id = key.second, .asked = it->second.asked},
              .why = "the gateway that asked for it has ended it or is not there"});
    adopted_.erase(it);
    to_send_.remove(key.first, key.second);
    view.adopt(key.first, key.second, false);
  }
  if (record == nullptr) return;
  if (!adopted_.contains(key)) {
    adopted_[key].asked = record->create;
    view.adopt(key.first, key.second, true);
    events.emplace_back(
        Adopt{.origin = {.gateway = key.first, .id = key.second, .asked = record->create},
              .admission = record->asked.admission,
              .footprint = taken_for(view, key, record->asked)});
  }
  open(key, view, events);
}

void Adoptions::open(const Records::AskedKey& key, const View& view, std::vector<Event>& events) {
  const AskedRecord* record = live(view, key);
  Adopted& adopted = adopted_.at(key);
  if (record == nullptr || record->asked.stage != Stage::granted || adopted.opened ||
      !adopted.vote || !adopted.vote->ok)
    return;
  adopted.opened = true;
  events.emplace_back(
      Opened{.origin = {.gateway = key.first, .id = key.second, .asked = adopted.asked}});
}

void Adoptions::step(View& view, bool joined, std::vector<Event>& events) {
  if (!joined) return;
  for (const Records::AskedKey& key : view.take_touched()) take_up(key, view, events);
}

void Adoptions::vote(const Origin& origin, Vote vote, View& view, std::vector<Event>& events) {
  const Records::AskedKey key{origin.gateway, origin.id};
  const auto it = adopted_.find(key);
  if (it == adopted_.end() || it->second.asked != origin.asked) return;
  if (!vote.ok) it->second.opened = false;
  if (it->second.vote != vote) ++it->second.number;
  it->second.vote = std::move(vote);
  if (it->second.stored != it->second.number) to_send_.add(key.first, key.second);
  open(key, view, events);
}

void Adoptions::note_stored(const Work::Answer& answer, std::size_t gateway) {
  const auto it = adopted_.find({gateway, answer.id});
  // Another admission may have this number since.
  if (it == adopted_.end() || it->second.asked != answer.asked) return;
  it->second.stored = answer.number;
  if (it->second.stored == it->second.number) to_send_.remove(gateway, answer.id);
}

/// After a conflict, one of the admissions has changed or is gone, which the view will show. The
/// votes on the others are sent again.
void Adoptions::on_done(const Done& done, const View& view) {
  const bool conflict = done.fate == Done::Fate::conflict;
  if (done.work.kind != Work::Kind::vote || (!conflict && done.fate != Done::Fate::done)) return;
  for (const Work::Answer& answer : done.work.answers) {
    const std::string key = view.keys().asked(done.work.gateway, answer.id);
    const auto there = std::ranges::find(done.read, key, &Entry::key);
    const bool unchanged =
        there != done.read.end() && !there->gone && there->create == answer.asked;
    if (!conflict || !unchanged) note_stored(answer, done.work.gateway);
  }
}

void Adoptions::lose(View& view) {
  for (const auto& key : std::views::keys(adopted_)) view.adopt(key.first, key.second, false);
  adopted_.clear();
  to_send_.clear();
  view.touch_asked();
}

std::optional<Work> Adoptions::next_work(const View& view, const Codec& codec) {
  const Keys& keys = view.keys();
  const auto gateway = to_send_.next();
  if (!gateway) return std::nullopt;
  to_send_.took(*gateway);
  Work work{.kind = Work::Kind::vote, .gateway = *gateway};
  for (const std::uint64_t id : to_send_.of(*gateway)) {
    if (work.answers.size() == kMostVotes) break;
    const Adopted& adopted = adopted_.at({*gateway, id});
    work.answers.push_back({.id = id, .asked = adopted.asked, .number = adopted.number});
    work.compares.push_back({.what = Compare::What::create,
                             .key = keys.asked(*gateway, id),
                             .revision = adopted.asked});
    work.puts.push_back(
        {.key = keys.vote(self_, *gateway, id),
         .value = codec.write(VoteOf{.asked = adopted.asked, .vote = *adopted.vote})});
    work.reads.push_back(keys.asked(*gateway, id));
  }
  return work;
}

std::optional<Work> Adoptions::clean_up(const View& view) const {
  const Keys& keys = view.keys();
  Work clean{.kind = Work::Kind::vote};
  for (auto it = view.records().votes.lower_bound({self_, 0, 0});
       it != view.records().votes.end() && std::get<0>(it->first) == self_; ++it) {
    const Records::AskedKey key{std::get<1>(it->first), std::get<2>(it->first)};
    if (!adopted_.contains(key) && clean.deletes.size() < kMostDeletes)
      clean.deletes.push_back(keys.vote(self_, key.first, key.second));
  }
  return clean.deletes.empty() ? std::nullopt : std::optional(std::move(clean));
}

}  // namespace mlcca::core::cluster
