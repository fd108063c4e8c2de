// SPDX-License-Identifier: BSD-2-Clause
// Metrics of deliveries: from one publisher of a channel to one place.
#include <algorithm>
#include <functional>
#include <limits>
#include <unordered_map>

#include "tools/exporter/exposition.hpp"
#include "tools/exporter/metrics.hpp"

namespace mlcca::exporter {
namespace {

bool is_well(const control::Channel& c) { return c.granted && c.problems.empty(); }

/// Deliveries that differ only in the number of their admission. They form one series, because the
/// number is no label: each admission has a new number, so it would create new series all the time.
struct Delivery {
  Labels labels;
  std::vector<const control::Channel*> channels;

  [[nodiscard]] std::uint64_t sum(std::uint64_t control::Channel::* count) const {
    std::uint64_t all = 0;
    for (const auto* c : channels) all += c->*count;
    return all;
  }
  [[nodiscard]] bool all(const std::function<bool(const control::Channel&)>& holds) const {
    return std::ranges::all_of(channels, [&](const auto* c) { return holds(*c); });
  }
};

std::vector<Delivery> deliveries_of(const control::Channels& channels, std::size_t most,
                                    std::size_t& left_out) {
  std::vector<Delivery> all;
  std::unordered_map<std::string, std::size_t> by_labels;
  for (const auto& c : channels.channels) {
    Labels labels{{"channel", c.name}, {"publisher", c.publisher}, {"from", c.from}, {"to", c.to}};
    const auto [known, is_new] = by_labels.try_emplace(labels.text(), all.size());
    if (is_new) all.push_back({std::move(labels), {}});
    all[known->second].channels.push_back(&c);
  }
  if (all.size() <= most) return all;
  // Deliveries with a problem are among those with series.
  std::ranges::stable_partition(all, [](const Delivery& d) { return !d.all(is_well); });
  left_out = all.size() - most;
  all.erase(all.begin() + static_cast<std::ptrdiff_t>(most), all.end());
  return all;
}

struct Watches {
  Family events{"mlcca_delivery_events_total", "counter",
                "Events of a periodic publisher that came to the gate that they enter by."};
  Family missing{"mlcca_delivery_events_missing_total", "counter", "Events that did not come."};
  Family missing_now{"mlcca_delivery_missing", "gauge",
                     "Whether more events in a row are missing than may be."};
  Family since{"mlcca_delivery_since_last_event_seconds", "gauge",
               "Age of the latest event; before the first one, of the grant."};
  Family period{"mlcca_delivery_period_seconds", "gauge", "Period that the publisher states."};
  Family jitter{"mlcca_delivery_jitter_seconds", "gauge",
                "The furthest that a gap between two events was from the period."};

  void add(const Labels& labels, const control::Watch& watch) {
    events.add(labels, watch.events);
    missing.add(labels, watch.missing);
    missing_now.add(labels, watch.missing_now);
    since.add(labels, in_seconds(watch.since_last_ns));
    if (watch.period_ns != 0) period.add(labels, in_seconds(watch.period_ns));
    if (watch.last_gap_ns != 0 && !watch.shared) jitter.add(labels, in_seconds(watch.jitter_ns));
  }
  void append_to(std::string& page) const {
    for (const auto* family : {&events, &missing, &missing_now, &since, &period, &jitter})
      family->append_to(page);
  }
};

struct Responses {
  Family response{"mlcca_delivery_response_seconds", "gauge",
                  "Longest response time on a CAN bus of its way, with what is on the bus now."};
  Family guaranteed{"mlcca_delivery_response_guaranteed_seconds", "gauge",
                    "What the response time cannot exceed, whoever is admitted later."};

  void add(const Labels& labels, const std::vector<control::MediumUse>& media) {
    for (const auto& m : media) {
      const auto on = labels.with("network", m.network);
      if (m.response_ns != 0) response.add(on, in_seconds(m.response_ns));
      if (m.guaranteed_ns != 0 && m.guaranteed_ns != std::numeric_limits<std::uint64_t>::max())
        guaranteed.add(on, in_seconds(m.guaranteed_ns));
    }
  }
};

/// The worst watch of the deliveries of a series.
const control::Watch* watch_of(const Delivery& delivery) {
  const control::Watch* worst = nullptr;
  for (const auto* c : delivery.channels)
    if (c->watch && (worst == nullptr || (c->watch->missing_now && !worst->missing_now)))
      worst = &*c->watch;
  return worst;
}

}  // namespace

void add_deliveries(const control::Channels& channels, const Most& most, LeftOut& left_out,
                    std::string& page) {
  using control::Channel;
  Family granted("mlcca_delivery_granted", "gauge", "Whether the delivery is granted.");
  Family set("mlcca_delivery_attribute_set", "gauge",
             "Attribute set in use, 1 is the preferred one; only where there is a choice.");
  Family problems("mlcca_delivery_problems", "gauge", "How many problems what was granted has.");
  Family supervised("mlcca_delivery_supervised", "gauge",
                    "Whether the silence of this heart-beat would be reported.");
  Family shared("mlcca_delivery_shared", "gauge",
                "Whether its publisher looks like others to the gate: frames and events of all of "
                "them are counted for each, so that a sum over publishers counts them again.");
  Family withdrawn("mlcca_delivery_withdrawn", "gauge",
                   "Whether an operator has withdrawn the channel.");
  Family passed("mlcca_delivery_frames_passed_total", "counter", "Frames that passed.");
  Family dropped("mlcca_delivery_frames_dropped_total", "counter", "Frames that were dropped.");
  Family excess("mlcca_delivery_frames_excess_total", "counter",
                "Frames in excess of what was admitted, dropped or not.");
  Family would_drop("mlcca_delivery_frames_would_drop_total", "counter",
                    "Frames that audit mode passed.");
  Watches watches;
  Responses responses;
  for (const auto& d : deliveries_of(channels, most.deliveries, left_out["deliveries"])) {
    const auto& labels = d.labels;
    const Channel& c = *d.channels.front();
    granted.add(labels, d.all([](const Channel& one) { return one.granted; }));
    if (c.granted && c.sets > 1) set.add(labels, std::uint64_t{c.set} + 1);
    std::uint64_t wrong = 0;
    for (const auto* one : d.channels) wrong += one->problems.size();
    problems.add(labels, wrong);
    supervised.add(labels, d.all([](const Channel& one) { return one.not_supervised.empty(); }));
    shared.add(labels, std::ranges::any_of(d.channels, &Channel::counts_shared));
    withdrawn.add(labels, c.withdrawn);
    // Without a gate on the way no frame is counted; the value 0 would state that nothing passes.
    if (!d.all(&Channel::crosses_no_gate)) passed.add(labels, d.sum(&Channel::passed));
    dropped.add(labels, d.sum(&Channel::dropped));
    excess.add(labels, d.sum(&Channel::excess));
    would_drop.add(labels, d.sum(&Channel::would_drop));
    if (const auto* watch = watch_of(d)) watches.add(labels, *watch);
    if (c.granted) responses.add(labels, c.media);
  }
  for (const auto* family : {&granted, &set, &problems, &supervised, &shared, &withdrawn, &passed,
                             &dropped, &excess, &would_drop})
    family->append_to(page);
  watches.append_to(page);
  responses.response.append_to(page);
  responses.guaranteed.append_to(page);
}

}  // namespace mlcca::exporter
