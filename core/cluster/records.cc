// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/records.hpp"

#include <algorithm>
#include <iterator>

namespace mlcca::core::cluster {
namespace {

/// The most gateways that only a former description had. Entries of further ones are never
/// considered to be over.
constexpr std::size_t kMostLeft = 1024;
constexpr std::size_t kMostLeftKeys = 4096;

/// Decodes the value of an entry; nullopt if it is gone or too long.
template <class Read>
auto value_of(const Entry& entry, Read read) -> decltype(read(entry.value)) {
  if (entry.gone || entry.value.size() > kMostEntryBytes) return std::nullopt;
  return read(entry.value);
}

template <class T, class Read>
void keep(Record<T>& record, const Entry& entry, Read read) {
  record = {.value = value_of(entry, read), .mod = entry.gone ? 0 : entry.mod};
}

void keep_member(MemberRecord& member, const Codec& codec, const Entry& entry) {
  member.beat = value_of(entry, [&](const auto& v) { return codec.beat(v); });
  member.lease = member.beat ? member.beat->lease : 0;
  if (member.beat && (member.beat->lease < kLeastLease || member.beat->lease > kMostLease))
    member.beat.reset();
  member.mod = entry.gone ? 0 : entry.mod;
}

/// Makes room for one more entry that `gateway` has written, if there are as many as there may be:
/// the gateway with the most of them loses its last. False if none has more than `gateway` would
/// have then.
template <class Entries>
bool make_room(Entries& all, std::vector<std::size_t>& counts, std::size_t gateway) {
  if (all.size() < kMostReservations) return true;
  const auto most = std::ranges::max_element(counts);
  if (*most <= counts[gateway] + 1) return false;
  typename Entries::key_type after{};
  std::get<0>(after) = static_cast<std::size_t>(most - counts.begin()) + 1;
  all.erase(std::prev(all.lower_bound(after)));
  --*most;
  return true;
}

/// Keeps or removes an entry. The first part of its key is the gateway that has written it, and
/// `counts` has the number of entries of each.
template <class Entries>
void keep_fairly(Entries& all, std::vector<std::size_t>& counts,
                 const typename Entries::key_type& at,
                 std::optional<typename Entries::mapped_type> value) {
  const std::size_t gateway = std::get<0>(at);
  if (!value) {
    counts[gateway] -= all.erase(at);
    return;
  }
  if (!all.contains(at)) {
    if (!make_room(all, counts, gateway)) return;
    ++counts[gateway];
  }
  all[at] = std::move(*value);
}

}  // namespace

void Records::note(const Entry& entry, bool understood, std::optional<std::size_t> network,
                   Strangeness why) {
  if (why == Strangeness::value && entry.value.size() > kMostEntryBytes)
    why = Strangeness::too_long;
  if (understood || entry.gone)
    strange.erase(entry.key);
  else if (strange.size() < kMostStrange || strange.contains(entry.key))
    strange[entry.key] = {.network = network, .why = why, .octets = entry.value.size()};
  else
    too_many = Exceeded::strange;
}

void Records::put_reservation(const Codec& codec, const Key& key, const Entry& entry) {
  const ReservationKey at{.network = key.network, .gateway = key.gateway, .id = key.id};
  if (entry.gone) {
    reservations.erase(at);
    note(entry, true, key.network);
    return;
  }
  if (reservations.size() >= kMostReservations && !reservations.contains(at)) {
    too_many = Exceeded::reservations;
    return;
  }
  auto taken = value_of(entry, [&](const auto& v) { return codec.taken(v, key.network); });
  note(entry, taken.has_value(), key.network,
       taken || !codec.of_other_description(entry.value) ? Strangeness::value : Strangeness::other);
  reservations[at] = {.taken = std::move(taken), .mod = entry.mod};
}

void Records::put_asked(const Codec& codec, const Key& key, const Entry& entry) {
  auto value = value_of(entry, [&](const auto& v) { return codec.asked(v); });
  note(entry, value.has_value(), std::nullopt);
  std::optional<AskedRecord> record;
  if (value) record = {.asked = std::move(*value), .create = entry.create, .mod = entry.mod};
  keep_fairly(asked, asked_counts_, {key.gateway, key.id}, std::move(record));
}

/// Without a vote nothing is granted, so what exceeds the limit is only ignored.
void Records::put_vote(const Codec& codec, const Key& key, const Entry& entry) {
  Record<VoteOf> record;
  keep(record, entry, [&](const auto& v) { return codec.vote(v); });
  note(entry, record.value.has_value(), std::nullopt);
  keep_fairly(votes, vote_counts_, {key.gateway, key.from, key.id},
              record.value ? std::optional(std::move(record)) : std::nullopt);
}

void Records::put_member(const Codec& codec, const Key& key, const Entry& entry) {
  MemberRecord& member = members[key.gateway];
  keep_member(member, codec, entry);
  note(entry, member.beat.has_value(), std::nullopt,
       member.lease != 0 ? Strangeness::lease : Strangeness::value);
}

void Records::put_blob(const Key& key, const Entry& entry) {
  const auto at = std::pair(key.digest, key.id);
  if (entry.gone || entry.value.size() > kMostChunkBytes || key.id >= kMostChunks)
    blobs.erase(at);
  else if (blobs.size() < kMostBlobs || blobs.contains(at))
    blobs[at] = entry.value;
}

void Records::put_description(const Codec& codec, const Key& key, const Entry& entry) {
  if (key.kind == Key::Kind::current) {
    keep(current, entry, [&](const auto& v) { return codec.current(v); });
    note(entry, current.value.has_value(), std::nullopt);
  } else if (key.kind == Key::Kind::next) {
    keep(next, entry, [&](const auto& v) { return codec.next(v); });
    if (next.value && next.value->chunks > kMostChunks) next.value.reset();
    note(entry, next.value.has_value(), std::nullopt);
  } else {
    auto& record = rollout_votes[key.gateway];
    keep(record, entry, [&](const auto& v) { return codec.rollout_vote(v); });
    note(entry, record.value.has_value(), std::nullopt);
  }
}

void Records::put_left(const Codec& codec, const LeftKey& key, const Entry& entry) {
  auto it = left.find(key.gateway);
  if (it == left.end()) {
    if (entry.gone || left.size() >= kMostLeft) return;
    it = left.emplace(std::string(key.gateway), LeftRecord{}).first;
  }
  LeftRecord& record = it->second;
  if (entry.gone)
    left_keys -= record.keys.erase(entry.key);
  else if (const auto known = record.keys.find(entry.key); known != record.keys.end())
    known->second.mod = entry.mod;
  else if (left_keys < kMostLeftKeys)
    left_keys +=
        record.keys
                .emplace(entry.key,
                         LeftRecord::Key{.kind = key.kind, .voter = key.voter, .mod = entry.mod})
                .second
            ? 1
            : 0;
  if (key.kind == Key::Kind::member)
    keep_member(record.member, codec, entry);
  else if (key.kind == Key::Kind::fence)
    record.member.fence = entry.gone ? 0 : entry.mod;
  else if (entry.gone)
    record.taken.erase(entry.key);
  else if (key.kind == Key::Kind::reservation && key.network && strange.contains(entry.key))
    record.taken[entry.key] = {.network = *key.network, .mod = entry.mod};
}

std::optional<Key> Records::put(const Keys& keys, const Codec& codec, const Entry& entry) {
  auto key = keys.parse(entry.key);
  if (!key) {
    note(entry, false, keys.network_of(entry.key), Strangeness::key);
    if (const auto of = keys.parse_left(entry.key)) put_left(codec, *of, entry);
    return key;
  }
  switch (key->kind) {
    case Key::Kind::epoch:
      keep(epoch, entry, [&](const auto& v) { return codec.epoch(v); });
      note(entry, epoch.value.has_value(), std::nullopt);
      break;
    case Key::Kind::current:
    case Key::Kind::next:
    case Key::Kind::rollout_vote:
      put_description(codec, *key, entry);
      break;
    case Key::Kind::blob:
      put_blob(*key, entry);
      break;
    case Key::Kind::member:
      put_member(codec, *key, entry);
      break;
    case Key::Kind::fence:
      members[key->gateway].fence = entry.gone ? 0 : entry.mod;
      break;
    case Key::Kind::version:
      versions[key->network] = entry.gone ? 0 : entry.mod;
      break;
    case Key::Kind::reservation:
      put_reservation(codec, *key, entry);
      break;
    case Key::Kind::asked:
      put_asked(codec, *key, entry);
      break;
    case Key::Kind::vote:
      put_vote(codec, *key, entry);
      break;
  }
  return key;
}

bool Records::unreadable(std::size_t network) const {
  return too_many != Exceeded::no || std::ranges::any_of(strange, [&](const auto& entry) {
           return entry.second.network == std::optional(network);
         });
}

}  // namespace mlcca::core::cluster
