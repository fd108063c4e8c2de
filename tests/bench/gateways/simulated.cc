// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bench/gateways/simulated.hpp"

#include <fmt/core.h>

#include <utility>
#include <variant>

#include "base/clock.hpp"
#include "cluster/etcd.hpp"
#include "cluster/grpc.hpp"
#include "cluster/http.hpp"
#include "cluster/outcome.hpp"
#include "description/read.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::bench {
namespace {

namespace cc = core::cluster;

constexpr std::uint64_t kTimeout = 60'000;  // ms
constexpr std::uint64_t kFirstNumber = std::uint64_t{1} << 62U;

/// What mlccad would reserve on an Ethernet for that admission.
cc::Part part_of(std::size_t network, core::AdmissionId admission) {
  cc::Part part;
  part.network = network;
  part.rates.push_back({.bytes_per_second = 800, .source = {.admission = admission}});
  return part;
}

/// The request of "mlccactl admit c1 --from g17 --to n1 --user 0 --key k17-1 --offer … --offer …".
std::string admission_of(const core::System& system, std::size_t gateway, std::size_t network,
                         core::AdmissionId admission) {
  control::Admit admit;
  admit.channel = "c1";
  admit.from = system.gateways[gateway].name;
  admit.to = system.networks[network].name;
  admit.user = "0";
  admit.key = fmt::format("k{}-{}", gateway, admission);
  admit.offered = {{.name = "Period", .value = 10'000'000, .unit = "ns"},
                   {.name = "MaxPayload", .value = 8, .unit = "bytes"}};
  return cluster::text_of(
      {.channel = "c1", .requests = {control::Request{.id = admission, .body = std::move(admit)}}});
}

}  // namespace

Described::Described(const std::string& file) {
  auto read = description::read(file, description::Users::any, &digest);
  if (!read) give_up(file + ": " + read.error().front().text);
  system = std::move(*read);
  keys = std::make_shared<cc::Keys>(system, "/mlcca/" + cc::encoded(system.name) + '/');
  codec = std::make_unique<cluster::RecordCodec>(system, digest);
  cc::Current in_force;
  in_force.generation = 1;
  in_force.digest = digest;
  in_force.open = true;
  current = {.key = keys->current(), .value = codec->write(in_force)};
}

Simulated::Simulated(const Place& place, const cluster::Settings& settings,
                     const std::string& endpoint)
    : place_(place),
      member_(place.described.keys, *place.described.codec,
              cc::Member::Identity{.gateway = place.gateway,
                                   .digest = place.described.digest,
                                   .session = kFirstNumber + place.gateway,
                                   .lease = place.lease,
                                   .was = {}}) {
  auto channel = cluster::open_http(place.loop, settings, endpoint);
  if (!channel) give_up(channel.error().text);
  channel_ = std::move(*channel);
  sd_event_source* raw = nullptr;
  const auto on_time = [](sd_event_source*, std::uint64_t, void* self) noexcept {
    static_cast<Simulated*>(self)->pass(0);
    return 0;
  };
  if (sd_event_add_time(place.loop, &raw, CLOCK_MONOTONIC, 0, 1, on_time, this) < 0)
    give_up("no timer");
  timer_.reset(raw);
  sd_event_source_set_enabled(raw, SD_EVENT_OFF);
}

Value Simulated::now() const { return monotonic_ns() + later_; }

void Simulated::begin() {
  cc::StoreState state;
  state.reachable = true;
  member_.on_state(state, now());
  const cc::Entry& current = place_.described.current;
  member_.on_snapshot_begin(current.mod, now());
  member_.on_batch({.revision = current.mod, .entries = {current}}, now());
  member_.on_snapshot_end(now());
  pump();
}

cc::Wanted Simulated::wanted() const {
  return {
      .id = kFirstNumber + next_,
      .footprint = {.parts = {part_of(place_.network, next_)}, .gateways = {}},
      .channel = "c1",
      .admission = admission_of(place_.described.system, place_.gateway, place_.network, next_)};
}

void Simulated::reserve() {
  ++next_;
  member_.reserve(wanted(), now());
  pump();
}

void Simulated::pass(Value later) {
  later_ += later;
  member_.on_time(now());
  pump();
}

void Simulated::observe(const cc::Batch& batch) {
  member_.on_batch(batch, now());
  pump();
}

void Simulated::take(const cc::Event& event) {
  if (std::holds_alternative<cc::Joined>(event)) {
    joined_ = true;
  } else if (std::holds_alternative<cc::Reserved>(event)) {
    ++granted_;
    if (on_granted) on_granted();
  } else if (std::holds_alternative<cc::Conflict>(event)) {
    ++conflicts_;
    member_.reserve(wanted(), now());
  } else if (std::holds_alternative<cc::Refused>(event)) {
    if (on_refused) on_refused();
  }
}

void Simulated::pump() {
  for (auto events = member_.take_events(); !events.empty(); events = member_.take_events())
    for (const cc::Event& event : events) take(event);
  for (cc::Txn& txn : member_.take_txns(now())) send(std::move(txn));
  // For later times the bench calls pass().
  const Value due = member_.next_time(now());
  if (due > now() + cc::Admissions::kLongestWait) return;
  sd_event_source_set_time(timer_.get(), ((due - later_) / 1000) + 1);
  sd_event_source_set_enabled(timer_.get(), SD_EVENT_ONESHOT);
}

void Simulated::send(cc::Txn txn) {
  txn_ = std::move(txn);
  std::string message = cluster::etcd::txn_request(txn_);
  octets_ += message.size();
  ++transactions_;
  answer_.clear();
  sent_ = Steady::now();
  call_ = channel_->start({.method = cluster::etcd::kTxn,
                           .message = std::move(message),
                           .timeout_ms = kTimeout,
                           .on_answer = [this](std::string octets) { answer_ = std::move(octets); },
                           .on_end = [this](const cluster::End& end) { this->end(end); }});
}

void Simulated::end(const cluster::End& end) {
  latest_ms_ = ms_since(sent_);
  const auto call = std::move(call_);
  cc::TxnResult result{.id = txn_.id, .outcome = cluster::outcome_of(end), .why = end.text};
  if (auto read = cluster::etcd::read_txn(answer_, txn_.else_get);
      read && end.status == cluster::grpc::kOk) {
    result.outcome = read->succeeded ? cc::Outcome::committed : cc::Outcome::conflict;
    result.revision = read->header.revision;
    result.read = std::move(read->read);
  }
  const bool answered =
      result.outcome == cc::Outcome::committed || result.outcome == cc::Outcome::conflict;
  if (!answered) {
    place_.trouble = "a transaction of a simulated gateway failed: " + result.why;
    return;
  }
  member_.on_result(result, now());
  if (result.outcome == cc::Outcome::committed) committed(result.revision);
  pump();
}

/// Passes the own changes on, as a watch of the store would.
void Simulated::committed(std::int64_t revision) {
  cc::Batch own{.revision = revision, .entries = {}};
  cc::Batch version{.revision = revision, .entries = {}};
  for (cc::Put& put : txn_.puts) {
    cc::Entry entry{.key = std::move(put.key), .value = std::move(put.value), .mod = revision};
    entry.create = revision;
    if (entry.key == place_.described.keys->version(place_.network))
      version.entries.push_back(entry);
    own.entries.push_back(std::move(entry));
  }
  for (std::string& key : txn_.deletes)
    own.entries.push_back({.key = std::move(key), .value = {}, .mod = revision, .gone = true});
  member_.on_batch(own, now());
  if (on_changed && !version.entries.empty()) on_changed(version);
}

EntrySizes entry_sizes(const Described& described) {
  cc::Taken taken{.channel = "c1", .publisher = {}, .part = part_of(0, 1), .through = {}};
  EntrySizes sizes;
  sizes.rate = described.codec->write(taken).size();
  taken.part.bus.push_back({.message = {.priority = 0x123,
                                        .lowest_priority = 0x123,
                                        .frames = 1,
                                        .transmission = 270'000,
                                        .longest_frame = 270'000,
                                        .last_frame = 270'000,
                                        .period = 10'000'000,
                                        .deadline = 10'000'000,
                                        .jitter = 1'000'000,
                                        .queue = 1},
                            .first_id = 0x123,
                            .last_id = 0x123,
                            .subject = std::uint64_t{1} << 60U,
                            .source = {.admission = 1}});
  sizes.message = described.codec->write(taken).size();
  cc::RouteRequest asked;
  asked.stage = cc::Stage::granted;
  asked.admission = admission_of(described.system, 0, 0, 1);
  sizes.asked = described.codec->write(asked).size();
  cc::Beat beat;
  beat.incarnation = 1'000;
  beat.session = kFirstNumber;
  beat.seq = 1'000;
  beat.digest = described.digest;
  beat.generation = 1;
  beat.applied = 1'000'000;
  beat.role = cc::Role::active;
  beat.lease = 10'000'000'000;
  sizes.beat = described.codec->write(beat).size();
  return sizes;
}

}  // namespace mlcca::bench
