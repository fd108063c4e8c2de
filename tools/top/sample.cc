// SPDX-License-Identifier: BSD-2-Clause
#include "tools/top/sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "control/watches.hpp"
#include "core/model/text.hpp"
#include "mlcca/arithmetic.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools::top {
namespace {

constexpr double kSecond = 1e9;

struct Counts {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t would_drop = 0;
  std::uint64_t events = 0;  ///< of supervised publishers
};

/// Converts differences of counters between two moments into rates per second.
class Interval {
 public:
  Interval(const Sample* before, const Sample& now)
      : seconds_(before == nullptr || now.at_ns <= before->at_ns
                     ? 0
                     : static_cast<double>(now.at_ns - before->at_ns) / kSecond) {}

  [[nodiscard]] std::optional<double> rate(const std::uint64_t* before, std::uint64_t now) const {
    if (seconds_ == 0 || before == nullptr) return std::nullopt;
    return static_cast<double>(now >= *before ? now - *before : now) / seconds_;
  }

 private:
  double seconds_;
};

using Key = std::tuple<std::uint64_t, std::string, std::uint64_t, std::string>;

Counts counts_of(const control::Channel& c) {
  return {c.passed, c.dropped, c.would_drop, c.watch ? c.watch->events : 0};
}

Key key_of(const control::Channel& c) { return {c.subject, c.publisher, c.admission, c.to}; }

std::map<Key, Counts> delivery_counts(const Sample* sample) {
  std::map<Key, Counts> counts;
  if (sample != nullptr)
    for (const auto& c : sample->channels.channels) counts.try_emplace(key_of(c), counts_of(c));
  return counts;
}

/// Sums over all interfaces of each network.
std::map<std::string, Counts> network_counts(const Sample* sample) {
  std::map<std::string, Counts> counts;
  if (sample != nullptr)
    for (const auto& i : sample->status.interfaces) {
      auto& sum = counts[i.network];
      sum.passed += i.ingress.passed + i.egress.passed;
      sum.dropped += i.ingress.dropped + i.egress.dropped;
      sum.would_drop += i.ingress.would_drop + i.egress.would_drop;
    }
  return counts;
}

/// The rate of refused frames: in audit mode those that would be dropped, otherwise those that are.
std::optional<double> drop_rate(const Interval& interval, const Sample& now, const Counts* before,
                                const Counts& counts) {
  const auto what = now.status.mode == "audit" ? &Counts::would_drop : &Counts::dropped;
  return interval.rate(before == nullptr ? nullptr : &(before->*what), counts.*what);
}

template <class Map, class K>
const Counts* find(const Map& counts, const K& key) {
  const auto known = counts.find(key);
  return known == counts.end() ? nullptr : &known->second;
}

/// The announced period of the events, in ns; 0: none is announced.
std::uint64_t period_of(const control::Channel& c) {
  if (c.watch && c.watch->period_ns != 0) return c.watch->period_ns;
  std::uint64_t period = 0;
  for (const auto& row : c.rows)
    if (row.attribute == "Period" && row.required != 0 && row.required != kUnbounded)
      period = period == 0 ? row.required : std::min(period, row.required);
  return period;
}

std::optional<double> share(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

void raise(std::optional<double>& most, std::optional<double> value) {
  if (value && (!most || *most < *value)) most = value;
}

/// Channel, publisher, and the admission that added the publisher (0: it is described).
using Holder = std::tuple<std::string, std::string, std::uint64_t>;

bool is_of(const control::Resource& resource, const std::string& place) {
  return resource.name == place || resource.name.starts_with(place + ": ");
}

/// The share of each resource that a publisher holds with all its flows there.
using Shares = std::map<const control::Resource*, double>;

std::map<Holder, Shares> shares_held(const control::Reservations& all) {
  std::map<Holder, Shares> held;
  for (const auto& resource : all.resources) {
    if (!resource.capacity_known) continue;
    for (const auto& r : resource.reservations)
      if (const auto part = share(r.amount, resource.capacity))
        held[{r.channel, r.publisher, r.admission}][&resource] += *part;
  }
  return held;
}

/// The holder for a delivery; the admission of a delivery may also be that of a subscriber.
Holder holder_of(const control::Channel& c, const std::map<Holder, Shares>& held) {
  const Holder admitted{c.name, c.publisher, c.admission};
  return held.contains(admitted) ? admitted : Holder{c.name, c.publisher, 0};
}

/// The largest share that the delivery holds of a resource on its route.
std::optional<double> reserved_for(const control::Channel& c,
                                   const std::map<Holder, Shares>& held) {
  std::optional<double> most;
  const auto shares = held.find(holder_of(c, held));
  if (shares == held.end()) return most;
  for (const auto& [resource, part] : shares->second) {
    const bool on_the_way = std::ranges::any_of(
        c.route, [&](const std::string& place) { return is_of(*resource, place); });
    if (on_the_way) raise(most, part);
  }
  return most;
}

/// " from 10.0.0.7 (02:00:5e:10:00:01)" as far as the sender is known.
std::string sender_of(const control::Unknown& frame) {
  const std::string sender = print_sender(frame);
  return sender.empty() ? "" : " from " + sender;
}

/// A row for frames without a slot, which were dropped because nothing of that identity is granted.
Row unknown_row(const control::Interface& interface, const control::Unknown& frame) {
  Row row;
  row.name = frame.subject != 0 ? core::format_subject(frame.subject) : print_can_id(frame.can_id);
  row.place = (frame.egress ? "> " : "") + interface.network + (frame.egress ? "" : " >") +
              sender_of(frame);
  row.subject = frame.subject != 0 ? row.name : "";
  row.verdict = "unknown";
  row.style = Style::warning;
  return row;
}

using UnknownKey = std::tuple<std::string, std::uint64_t, std::uint32_t, bool, bool, bool>;

UnknownKey key_of(const control::Interface& i, const control::Unknown& u) {
  return {i.name, u.subject, u.can_id, u.egress, u.fd, u.xl};
}

std::map<UnknownKey, std::uint64_t> unknown_counts(const Sample* sample) {
  std::map<UnknownKey, std::uint64_t> counts;
  if (sample != nullptr)
    for (const auto& i : sample->status.interfaces)
      for (const auto& u : i.unknown) counts[key_of(i, u)] = u.frames;
  return counts;
}

void add_unknown(const Interval& interval, const Sample* before, const Sample& now,
                 std::vector<Row>& rows) {
  const auto counted = unknown_counts(before);
  for (const auto& i : now.status.interfaces)
    for (const auto& u : i.unknown) {
      Row row = unknown_row(i, u);
      const auto old = counted.find(key_of(i, u));
      // Frames that were not listed before have come since then.
      const std::uint64_t none = 0;
      row.drops = interval.rate(old == counted.end() ? &none : &old->second, u.frames);
      rows.push_back(std::move(row));
    }
}

/// Adds jitter and loss. If several publishers share the identity the regularity of one is not
/// known.
void add_watch(const control::Watch& watch, Row& row) {
  if (watch.last_gap_ns != 0 && !watch.shared)
    row.jitter = static_cast<double>(watch.jitter_ns) / kSecond;
  if (!watch.shared) row.loss = share(watch.missing, add_saturating(watch.missing, watch.events));
  if (!watch.missing_now) return;
  row.verdict = control::is_coming_again(watch) ? "RETURNS" : "MISSING";
  row.style = Style::bad;
}

Row delivery(const control::Channel& c) {
  Row row;
  row.name = c.name;
  row.place = c.from + " > " + c.to;
  row.subject = fmt::format("0x{:016x}", c.subject);
  const auto verdict = verdict_cell(c.granted);
  row.verdict =
      c.granted && c.sets > 1 ? fmt::format("set {}/{}", c.set + 1, c.sets) : verdict.text;
  row.style = c.granted && c.set != 0 ? Style::warning : verdict.style;
  if (!c.problems.empty()) {
    const bool only_unsupervised = c.problems.size() == 1 && !c.not_supervised.empty();
    row.verdict = only_unsupervised ? "NOWATCH" : "PROBLEM";
    row.style = Style::bad;
  }
  if (c.watch) add_watch(*c.watch, row);
  return row;
}

/// The resource of a network of which the largest share is reserved.
const control::Resource* tightest(const control::Reservations& all, const std::string& network) {
  const control::Resource* found = nullptr;
  double most = -1;
  for (const auto& resource : all.resources) {
    if (!resource.capacity_known || !is_of(resource, network)) continue;
    const auto part = share(resource.reserved, resource.capacity);
    if (!part || *part <= most) continue;
    most = *part;
    found = &resource;
  }
  return found;
}

/// The used share of what is reserved of a resource, by the publishers whose use is known.
std::optional<double> used_of(const control::Resource& resource,
                              const std::map<Holder, double>& used) {
  double reserved = 0;
  double taken = 0;
  for (const auto& r : resource.reservations) {
    const auto known = used.find({r.channel, r.publisher, r.admission});
    if (known == used.end()) continue;
    reserved += static_cast<double>(r.amount);
    taken += static_cast<double>(r.amount) * known->second;
  }
  if (reserved == 0) return std::nullopt;
  return taken / reserved;
}

/// The used share of the reservation of each publisher, as far as it is known. `deliveries` are the
/// first rows, in the order of the channels.
std::map<Holder, double> used_by_holder(const Sample& now, const std::vector<Row>& deliveries) {
  std::map<Holder, double> used;
  const auto held = shares_held(now.reservations);
  for (std::size_t i = 0; i < now.channels.channels.size(); ++i) {
    if (!deliveries[i].used) continue;
    const auto& c = now.channels.channels[i];
    auto& most = used[holder_of(c, held)];
    most = std::max(most, *deliveries[i].used);
  }
  return used;
}

/// Sums up the deliveries that cross the network of `row`: how many are granted, and the worst of
/// the measured values.
void add_deliveries(const Sample& now, const std::vector<Row>& deliveries, Row& row) {
  std::size_t granted = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < now.channels.channels.size(); ++i) {
    const auto& c = now.channels.channels[i];
    if (std::ranges::find(c.route, row.name) == c.route.end() && c.from != row.name &&
        c.to != row.name)
      continue;
    ++all;
    granted += c.granted ? 1 : 0;
    raise(row.jitter, deliveries[i].jitter);
    raise(row.loss, deliveries[i].loss);
  }
  row.place = fmt::format("{} of {}", granted, all);
}

/// The rate of frames. For events that cross no gate, such as between programs, no frames are
/// counted.
std::optional<double> frame_rate(const Interval& interval, const Counts* before,
                                 const control::Channel& c) {
  std::optional<double> rate;
  if (!c.crosses_no_gate)
    rate = interval.rate(before == nullptr ? nullptr : &before->passed, c.passed);
  if (c.watch)
    raise(rate, interval.rate(before == nullptr ? nullptr : &before->events, c.watch->events));
  return rate;
}

}  // namespace

std::vector<Row> rows_by_subject(const Sample* before, const Sample& now) {
  const Interval interval(before, now);
  const auto counted = delivery_counts(before);
  const auto held = shares_held(now.reservations);
  std::vector<Row> rows;
  for (const auto& c : now.channels.channels) {
    Row row = delivery(c);
    const Counts* old = find(counted, key_of(c));
    row.rate = frame_rate(interval, old, c);
    row.drops = drop_rate(interval, now, old, counts_of(c));
    if (c.granted) {
      row.reserved = reserved_for(c, held);
      const auto period = period_of(c);
      // An event of several fragments consists of several frames.
      const auto events =
          c.watch ? interval.rate(old == nullptr ? nullptr : &old->events, c.watch->events)
                  : row.rate;
      if (events && period != 0) row.used = *events * static_cast<double>(period) / kSecond;
    }
    rows.push_back(std::move(row));
  }
  add_unknown(interval, before, now, rows);
  return rows;
}

std::vector<Row> rows_by_network(const Sample* before, const Sample& now) {
  const Interval interval(before, now);
  const auto counted = network_counts(before);
  const auto counts = network_counts(&now);
  const auto deliveries = rows_by_subject(before, now);
  const auto used = used_by_holder(now, deliveries);
  std::vector<Row> rows;
  for (const auto& network : now.networks.networks) {
    Row row;
    row.name = network.name;
    row.verdict = network.available ? "available" : "unavailable";
    row.style = network.available ? Style::good : Style::bad;
    add_deliveries(now, deliveries, row);
    if (const Counts* of = find(counts, network.name)) {
      const Counts* old = find(counted, network.name);
      row.rate = interval.rate(old == nullptr ? nullptr : &old->passed, of->passed);
      row.drops = drop_rate(interval, now, old, *of);
    }
    if (const auto* resource = tightest(now.reservations, network.name)) {
      row.reserved = share(resource->reserved, resource->capacity);
      row.used = used_of(*resource, used);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace mlcca::tools::top
