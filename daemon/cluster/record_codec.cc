// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/cluster/record_codec.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "base/text.hpp"
#include "control/protobuf.hpp"
#include "daemon/cluster/fields.hpp"

namespace mlcca::cluster {
namespace {

namespace cc = core::cluster;

constexpr std::size_t kMostReason = 512;  // bytes

template <std::size_t N>
std::string octets_of(const std::array<std::uint8_t, N>& from) {
  return {from.begin(), from.end()};
}

/// An array of exactly that length; zeros for an empty text; nullopt for any other length.
template <std::size_t N>
std::optional<std::array<std::uint8_t, N>> octets_in(const std::string& from) {
  std::array<std::uint8_t, N> out{};
  if (from.empty()) return out;
  if (from.size() != N) return std::nullopt;
  std::ranges::transform(from, out.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
  return out;
}
std::optional<cc::Digest> digest_in(const std::string& from) {
  return octets_in<std::tuple_size_v<cc::Digest>>(from);
}

bool is_revision(std::uint64_t number) {
  return number <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
}
std::uint64_t number_of(std::int64_t revision) {
  return revision < 0 ? 0 : static_cast<std::uint64_t>(revision);
}
std::int64_t revision_of(std::uint64_t number) { return static_cast<std::int64_t>(number); }

std::string bounded(const std::string& reason) { return printable(reason, kMostReason); }

SourceEntry entry_of(const cc::Source& source) {
  return {.publisher = source.publisher, .admission = source.admission, .origin = source.from};
}
cc::Source source_in(const SourceEntry& entry) {
  return {.publisher = entry.publisher, .admission = entry.admission, .from = entry.origin};
}

BusEntry entry_of(const cc::BusPart& part) {
  const core::can::Message& m = part.message;
  BusEntry entry{.priority = m.priority,
                 .lowest_priority = m.lowest_priority,
                 .frames = m.frames,
                 .back_to_back = m.back_to_back,
                 .transmission = m.transmission,
                 .longest_frame = m.longest_frame,
                 .last_frame = m.last_frame,
                 .period = m.period,
                 .deadline = m.deadline,
                 .jitter = m.jitter,
                 .least_pause = m.least_pause,
                 .pauses = m.pauses,
                 .first_id = part.first_id,
                 .last_id = part.last_id,
                 .extended = part.extended,
                 .subject = part.subject,
                 .source = entry_of(part.source)};
  if (m.queue != core::can::kOwnQueue) entry.queue = m.queue;
  if (m.sender != core::can::kNoSender) entry.sender = m.sender;
  return entry;
}
cc::BusPart bus_in(const BusEntry& entry) {
  cc::BusPart part{.message = {.priority = entry.priority,
                               .lowest_priority = entry.lowest_priority,
                               .frames = entry.frames,
                               .back_to_back = entry.back_to_back,
                               .transmission = entry.transmission,
                               .longest_frame = entry.longest_frame,
                               .last_frame = entry.last_frame,
                               .period = entry.period,
                               .deadline = entry.deadline,
                               .jitter = entry.jitter,
                               .queue = entry.queue.value_or(core::can::kOwnQueue),
                               .least_pause = entry.least_pause,
                               .pauses = entry.pauses,
                               .sender = entry.sender.value_or(core::can::kNoSender)},
                   .first_id = entry.first_id,
                   .last_id = entry.last_id,
                   .extended = entry.extended,
                   .subject = entry.subject,
                   .source = source_in(entry.source)};
  return part;
}

/// Whether a message of another gateway satisfies what the analysis assumes of messages that are
/// made here.
bool is_sound(const core::can::Message& m, std::size_t queues) {
  constexpr std::uint64_t longest = 3'600'000'000'000;  // ns
  const auto times = {m.transmission, m.deadline, m.jitter, m.least_pause, m.pauses};
  return m.frames != 0 && m.period != 0 && m.last_frame != 0 && m.last_frame <= m.transmission &&
         m.longest_frame >= m.last_frame && m.longest_frame <= m.transmission &&
         std::ranges::all_of(times, [](auto time) { return time <= longest; }) &&
         (m.queue == core::can::kOwnQueue || m.queue < queues);
}

template <class Entries, class Parts, class Make>
void put_all(const Parts& from, Entries& to, Make make) {
  to.reserve(from.size());
  for (const auto& one : from) to.push_back(make(one));
}

}  // namespace

RecordCodec::RecordCodec(const core::System& system, const cc::Digest& digest)
    : digest_(digest), publishers_(system.publishers.size()) {
  for (const core::Gateway& gateway : system.gateways) gateways_.push_back(gateway.name);
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    const core::Network& network = system.networks[n];
    networks_.push_back(network.name);
    Bounds bounds{.nodes = network.mesh ? network.mesh->nodes.size() : 0};
    for (const core::Gateway& gateway : system.gateways)
      if (gateway.port_on(n) != nullptr) ++bounds.queues;
    bounds_.push_back(bounds);
  }
}

std::vector<std::string> RecordCodec::names_of(const std::vector<std::size_t>& gateways) const {
  std::vector<std::string> names;
  names.reserve(gateways.size());
  for (const std::size_t g : gateways) names.push_back(gateways_[g]);
  return names;
}

std::optional<std::vector<std::size_t>> RecordCodec::gateways_of(
    const std::vector<std::string>& names) const {
  std::vector<std::size_t> all;
  for (const std::string& name : names) {
    const auto it = std::ranges::find(gateways_, name);
    if (it == gateways_.end()) return std::nullopt;
    all.push_back(static_cast<std::size_t>(it - gateways_.begin()));
  }
  std::ranges::sort(all);
  if (std::ranges::adjacent_find(all) != all.end()) return std::nullopt;
  return all;
}

bool RecordCodec::is_known(const cc::Source& source) const {
  const bool there = source.admission != 0 ? source.publisher == 0 : source.publisher < publishers_;
  return there &&
         (source.from == core::Flow::kOwn || source.from < networks_.size() + gateways_.size());
}

std::string RecordCodec::write(const cc::Beat& beat) const {
  return control::bytes_of(BeatEntry{.incarnation = number_of(beat.incarnation),
                                     .session = beat.session,
                                     .sequence = beat.seq,
                                     .digest = octets_of(beat.digest),
                                     .generation = beat.generation,
                                     .applied = number_of(beat.applied),
                                     .role = static_cast<std::uint32_t>(beat.role),
                                     .draining = beat.draining,
                                     .lease_ns = beat.lease});
}

std::optional<cc::Beat> RecordCodec::beat(Text value) const {
  const auto entry = control::message_in<BeatEntry>(value);
  if (!entry) return std::nullopt;
  const auto digest = digest_in(entry->digest);
  if (!digest || entry->role > static_cast<std::uint32_t>(cc::Role::active) ||
      !is_revision(entry->incarnation) || !is_revision(entry->applied))
    return std::nullopt;
  return cc::Beat{.incarnation = revision_of(entry->incarnation),
                  .session = entry->session,
                  .seq = entry->sequence,
                  .digest = *digest,
                  .generation = entry->generation,
                  .applied = revision_of(entry->applied),
                  .role = static_cast<cc::Role>(entry->role),
                  .draining = entry->draining,
                  .lease = entry->lease_ns};
}

std::string RecordCodec::write(const cc::Taken& taken) const {
  TakenEntry entry{.digest = octets_of(digest_),
                   .channel = taken.channel,
                   .publisher = taken.publisher,
                   .rates = {},
                   .bus = {},
                   .paths = {},
                   .through = names_of(taken.through)};
  put_all(taken.part.rates, entry.rates, [](const cc::RatePart& part) {
    return RateEntry{.bytes_per_second = part.bytes_per_second, .source = entry_of(part.source)};
  });
  put_all(taken.part.bus, entry.bus, [](const cc::BusPart& part) { return entry_of(part); });
  put_all(taken.part.paths, entry.paths, [](const cc::PathPart& part) {
    return PathEntry{.start = part.from,
                     .end = part.to,
                     .bytes_per_second = part.bytes_per_second,
                     .event_bytes = part.event_bytes,
                     .source = entry_of(part.source)};
  });
  return control::bytes_of(entry);
}

std::optional<cc::Taken> RecordCodec::taken(Text value, std::size_t network) const {
  const auto entry = control::message_in<TakenEntry>(value);
  if (!entry || digest_in(entry->digest) != digest_) return std::nullopt;
  auto through = gateways_of(entry->through);
  if (!through) return std::nullopt;
  cc::Taken taken{.channel = entry->channel,
                  .publisher = entry->publisher,
                  .part = {.network = network, .rates = {}, .bus = {}, .paths = {}},
                  .through = std::move(*through)};
  const Bounds& bounds = bounds_[network];
  bool sound = true;
  put_all(entry->rates, taken.part.rates, [&](const RateEntry& rate) {
    cc::RatePart part{.bytes_per_second = rate.bytes_per_second, .source = source_in(rate.source)};
    sound = sound && is_known(part.source);
    return part;
  });
  put_all(entry->bus, taken.part.bus, [&](const BusEntry& bus) {
    cc::BusPart part = bus_in(bus);
    sound = sound && is_known(part.source) && is_sound(part.message, bounds.queues);
    return part;
  });
  put_all(entry->paths, taken.part.paths, [&](const PathEntry& path) {
    cc::PathPart part{.from = path.start,
                      .to = path.end,
                      .bytes_per_second = path.bytes_per_second,
                      .event_bytes = path.event_bytes,
                      .source = source_in(path.source)};
    sound = sound && is_known(part.source) && std::max(part.from, part.to) < bounds.nodes;
    return part;
  });
  return sound ? std::optional(std::move(taken)) : std::nullopt;
}

std::string RecordCodec::write(const cc::RouteRequest& asked) const {
  return control::bytes_of(AskedEntry{.stage = static_cast<std::uint32_t>(asked.stage),
                                      .asking = asked.admission,
                                      .gateways = names_of(asked.gateways)});
}

bool RecordCodec::of_other_description(Text taken) const {
  const auto entry = control::message_in<TakenEntry>(taken);
  const auto digest = entry ? digest_in(entry->digest) : std::nullopt;
  return digest && *digest != digest_;
}

std::optional<cc::RouteRequest> RecordCodec::asked(Text value) const {
  auto entry = control::message_in<AskedEntry>(value);
  if (!entry || entry->stage > static_cast<std::uint32_t>(cc::Stage::ending)) return std::nullopt;
  auto gateways = gateways_of(entry->gateways);
  if (!gateways) return std::nullopt;
  // The other gateway must agree as well. Most admissions need nobody's agreement, and are not read
  // here.
  const auto asking = gateways->empty() ? std::nullopt : asked_in(entry->asking);
  std::optional<std::size_t> for_whom;
  for (const std::size_t g : *gateways)
    if (asking && asking->for_gateway == gateways_[g]) for_whom = g;
  return cc::RouteRequest{.stage = static_cast<cc::Stage>(entry->stage),
                          .admission = std::move(entry->asking),
                          .gateways = std::move(*gateways),
                          .made_for = for_whom};
}

std::string RecordCodec::write(const cc::VoteOf& vote) const {
  const auto name_in = [&](const std::vector<std::string>& names, std::size_t index) {
    return !vote.vote.ok && index < names.size() ? names[index] : std::string();
  };
  const auto& hop = vote.vote.hop;
  const bool is_network = hop && hop->kind == core::Place::Kind::network;
  return control::bytes_of(VoteEntry{
      .asked = number_of(vote.asked),
      .agrees = vote.vote.ok,
      .hop = hop ? name_in(is_network ? networks_ : gateways_, hop->index) : std::string(),
      .reason = bounded(vote.vote.reason),
      .final = !vote.vote.ok && vote.vote.final,
      .gateway = vote.vote.gateway ? name_in(gateways_, *vote.vote.gateway) : std::string()});
}

std::optional<cc::VoteOf> RecordCodec::vote(Text value) const {
  const auto entry = control::message_in<VoteEntry>(value);
  if (!entry || !is_revision(entry->asked)) return std::nullopt;
  cc::VoteOf vote{.asked = revision_of(entry->asked),
                  .vote = {.ok = entry->agrees,
                           .hop = {},
                           .reason = bounded(entry->reason),
                           .final = !entry->agrees && entry->final}};
  if (entry->agrees) return vote;
  const auto place = [&](const std::vector<std::string>& names, core::Place::Kind kind) {
    const auto it = std::ranges::find(names, entry->hop);
    if (it != names.end())
      vote.vote.hop = core::Place{kind, static_cast<std::size_t>(it - names.begin())};
  };
  place(gateways_, core::Place::Kind::gateway);
  place(networks_, core::Place::Kind::network);
  if (const auto it = std::ranges::find(gateways_, entry->gateway); it != gateways_.end())
    vote.vote.gateway = static_cast<std::size_t>(it - gateways_.begin());
  return vote;
}

std::string RecordCodec::write(const cc::Current& current) const {
  return control::bytes_of(CurrentEntry{.generation = current.generation,
                                        .digest = octets_of(current.digest),
                                        .former = octets_of(current.former),
                                        .open = current.open,
                                        .waits = current.waits,
                                        .undone = current.undone});
}

std::optional<cc::Current> RecordCodec::current(Text value) const {
  auto entry = control::message_in<CurrentEntry>(value);
  if (!entry) return std::nullopt;
  const auto digest = digest_in(entry->digest);
  const auto former = digest_in(entry->former);
  if (!digest || !former) return std::nullopt;
  return cc::Current{.generation = entry->generation,
                     .digest = *digest,
                     .former = *former,
                     .open = entry->open,
                     .waits = std::move(entry->waits),
                     .undone = entry->undone};
}

std::string RecordCodec::write(const cc::Next& next) const {
  return control::bytes_of(NextEntry{.generation = next.generation,
                                     .digest = octets_of(next.digest),
                                     .chunks = next.chunks,
                                     .by = next.by,
                                     .without = next.without,
                                     .patience_ns = next.patience,
                                     .force = next.force});
}

std::optional<cc::Next> RecordCodec::next(Text value) const {
  auto entry = control::message_in<NextEntry>(value);
  if (!entry) return std::nullopt;
  const auto digest = digest_in(entry->digest);
  if (!digest) return std::nullopt;
  return cc::Next{.generation = entry->generation,
                  .digest = *digest,
                  .chunks = entry->chunks,
                  .by = std::move(entry->by),
                  .without = std::move(entry->without),
                  .patience = entry->patience_ns,
                  .force = entry->force};
}

std::string RecordCodec::write(const cc::RolloutVote& vote) const {
  return control::bytes_of(
      JudgedEntry{.next = number_of(vote.next), .agrees = vote.ok, .reason = bounded(vote.reason)});
}

std::optional<cc::RolloutVote> RecordCodec::rollout_vote(Text value) const {
  const auto entry = control::message_in<JudgedEntry>(value);
  if (!entry || !is_revision(entry->next)) return std::nullopt;
  return cc::RolloutVote{
      .next = revision_of(entry->next), .ok = entry->agrees, .reason = bounded(entry->reason)};
}

/// The epoch as an operator writes it: only the octets.
std::optional<cc::Epoch> RecordCodec::epoch(Text value) const {
  if (value.empty()) return std::nullopt;
  return octets_in<std::tuple_size_v<cc::Epoch>>(std::string(value));
}

std::string text_of(const StoredRequest& asked) {
  return control::bytes_of(Asking{.channel = asked.channel,
                                  .requests = asked.requests,
                                  .also = asked.also,
                                  .on_behalf = asked.on_behalf,
                                  .for_gateway = asked.for_gateway,
                                  .for_number = asked.for_number});
}

std::optional<StoredRequest> asked_in(std::string_view text) {
  auto asking = control::message_in<Asking>(text);
  const auto admits = [](const control::Request& request) {
    return std::holds_alternative<control::Admit>(request.body);
  };
  if (!asking || !std::ranges::all_of(asking->requests, admits) ||
      !std::ranges::all_of(asking->also, admits))
    return std::nullopt;
  return StoredRequest{.channel = std::move(asking->channel),
                       .requests = std::move(asking->requests),
                       .also = std::move(asking->also),
                       .on_behalf = asking->on_behalf,
                       .for_gateway = std::move(asking->for_gateway),
                       .for_number = asking->for_number};
}

}  // namespace mlcca::cluster
