// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/adoptions.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

namespace mlcca::core::cluster {
namespace {

/// The most deletes of one transaction.
constexpr std::size_t kMostDeletes = 64;

/// What was reserved for an admission on all networks.
Footprint taken_for(const View& view, const Records::AskedKey& key) {
  Footprint footprint;
  const auto& reservations = view.records().reservations;
  for (std::size_t n = 0; n < view.keys().networks(); ++n) {
    const auto it = reservations.find({.network = n, .gateway = key.first, .id = key.second});
    if (it == reservations.end() || !it->second.taken) continue;
    footprint.parts.push_back(it->second.taken->part);
    footprint.gateways = it->second.taken->through;
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
    view.adopt(key.first, key.second, false);
  }
  if (record == nullptr) return;
  if (!adopted_.contains(key)) {
    adopted_[key].asked = record->create;
    view.adopt(key.first, key.second, true);
    events.emplace_back(
        Adopt{.origin = {.gateway = key.first, .id = key.second, .asked = record->create},
              .admission = record->asked.admission,
              .footprint = taken_for(view, key)});
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
  open(key, view, events);
}

void Adoptions::on_done(const Done& done) {
  if (done.work.kind != Work::Kind::vote) return;
  const auto it = adopted_.find({done.work.gateway, done.work.id});
  if (it == adopted_.end()) return;
  // After a conflict the admission has changed or is gone; the view will show that.
  if (done.fate == Done::Fate::done || done.fate == Done::Fate::conflict)
    it->second.stored = done.work.number;
}

void Adoptions::lose(View& view) {
  for (const auto& key : std::views::keys(adopted_)) view.adopt(key.first, key.second, false);
  adopted_.clear();
  view.touch_asked();
}

std::optional<Work> Adoptions::next_work(const View& view, const Codec& codec) const {
  const Keys& keys = view.keys();
  for (const auto& [key, adopted] : adopted_)
    if (adopted.stored != adopted.number)
      return Work{
          .kind = Work::Kind::vote,
          .id = key.second,
          .gateway = key.first,
          .number = adopted.number,
          .compares = {{.what = Compare::What::create,
                        .key = keys.asked(key.first, key.second),
                        .revision = adopted.asked}},
          .puts = {{.key = keys.vote(self_, key.first, key.second),
                    .value = codec.write(VoteOf{.asked = adopted.asked, .vote = *adopted.vote})}}};
  return std::nullopt;
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
