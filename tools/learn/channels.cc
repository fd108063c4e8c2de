// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/channels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <ranges>
#include <utility>

#include "base/many.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"
#include "tools/learn/arrivals.hpp"

namespace mlcca::learn {
namespace {

constexpr double kRegular = 0.9;      // share of gaps near the median from which a flow is periodic
constexpr std::uint64_t kBurst = 32;  // most events between those of a cycle
/// Longest gap over the median from which a flow is aperiodic.
constexpr std::uint64_t kFarApart = 10;

}  // namespace

std::string about(std::uint64_t ns) {
  std::uint64_t unit = 1;
  while (ns / unit >= 1000) unit *= 10;
  return tools::time_words((ns + unit / 2) / unit * unit);
}

std::uint64_t rounded_up(std::uint64_t value) {
  std::uint64_t unit = 1;
  while (value / unit >= 100) unit *= 10;
  return (value + unit - 1) / unit * unit;
}

std::uint64_t with_margin(std::uint64_t value, unsigned percent) {
  return rounded_up(value + value * percent / 100);
}

namespace {

/// Whether it was silent before the first and behind the last event for far longer than between
/// them: nothing of it is cut off by the recording.
bool is_complete(const Flow& flow, const Timeline& timeline) {
  const std::uint64_t far = flow.longest_gap() * kFarApart;
  const bool begun = flow.first_clock() != 0 || flow.first() > timeline.first() + far;
  const bool ended = flow.last_clock() != timeline.clock() || timeline.last() > flow.last() + far;
  return begun && ended;
}

/// The Period that what came for a small part of the time needs, by how many events there were in
/// all of the time that was recorded; 0: `period`, which is from its gaps, is the one.
std::uint64_t period_of_bursts(const Flow& flow, const Timeline& timeline, std::uint64_t period,
                               const TimesOptions& options) {
  constexpr std::uint64_t least = 1'000'000'000;  // ns
  constexpr std::uint64_t fewest = 8;             // gaps, of what is regular
  std::uint64_t time = std::max(timeline.covered(), options.listened);
  if (options.all_bursts) time = std::max(time, least);
  const std::uint64_t mean = time / flow.events();
  if (mean / kFarApart < period) return 0;
  const bool perhaps_cyclic = flow.gaps() >= fewest && flow.regular_share() >= kRegular;
  if (perhaps_cyclic && !options.all_bursts && !is_complete(flow, timeline)) return 0;
  return std::min(options.period_of_bursts, options.all_bursts ? mean : mean / 2);
}

// From so long runs on, traffic is cyclic with pauses, or bursts show how often their events come.
constexpr Flow::Run kRun{.cycles = 16, .ns = 500'000'000};
constexpr Flow::Run kRunOfBurst{.cycles = 4, .ns = 100'000'000};
constexpr Flow::Run kRunOfFew{.cycles = 2, .ns = 500'000'000};

/// Pauses between runs that are cyclic and at least that long; none of other traffic.
Flow::Pauses pauses_of(const Flow& flow, const Flow::Run& least, double regular = kRegular) {
  const Flow::Pauses out = flow.pauses(least);
  if (out.count != 0 && flow.regular_share(out.longest_other) >= regular) return out;
  return {.longest_other = flow.longest_gap()};
}

/// "2 pauses, the longest of 10s,"
std::string pauses_in_words(const Times& times) {
  return fmt::format("{} of {}", many(times.pauses, "pause", "pauses, the longest"),
                     about(times.longest_pause));
}

Times times_of_few(const Flow& flow, const Timeline& timeline, const TimesOptions& options) {
  Times out;
  out.period = options.assumed_period;
  out.seen = flow.events() < 2
                 ? "seen once: the Period is assumed"
                 : fmt::format(
                       "seen {} times, each alone in its recording or before time went "
                       "back: the Period is assumed",
                       flow.events());
  out.assumed = flow.gaps() == 0;
  if (out.assumed) return out;
  const bool is_half = options.few == OfFew::half_the_mean;
  const Flow::Pauses pauses =
      options.cycles_of_bursts && is_half ? flow.pauses(kRunOfFew) : Flow::Pauses{};
  const std::uint64_t mean =
      pauses.count == 0 ? flow.mean_of_few()
                        : std::min(flow.mean_of_few(pauses.longest_other), flow.median_gap());
  out.period = std::max<std::uint64_t>(tools::nominal(is_half ? mean / 2 : mean), 1000);
  const std::uint64_t longer =
      tools::nominal(period_of_bursts(flow, timeline, out.period, options));
  const bool is_burst = longer > out.period;
  if (is_burst) out.period = longer;
  out.bursts = is_burst || flow.comes_in_bursts();
  const std::uint64_t early = flow.early_of_few(out.period);
  out.jitter = early == 0 ? 0 : with_margin(early, 100);
  if (is_burst) {
    out.seen = fmt::format(
        "seen {} times only, in bursts, {} apart at least, and not for the rest of the time: the "
        "Period is assumed, and the Jitter twice what they were early by",
        flow.events(), about(flow.shortest_gap()));
    return out;
  }
  if (pauses.count != 0) {
    out.bursts = false;
    out.pauses = pauses.count;
    out.longest_pause = flow.longest_gap();
  }
  out.seen = fmt::format(
      "seen {} times only{}, every {} {}, {} apart at least: the Period is {}, and the "
      "Jitter twice what they were early by",
      flow.events(), out.bursts ? ", in bursts" : "", about(mean),
      out.pauses == 0 ? "in the mean" : "without " + pauses_in_words(out),
      about(flow.shortest_gap()),
      is_half ? "half of that" : "the mean, which its transport protocol needs");
  return out;
}

/// The median gap rounded as people state it, and within the gaps that were seen.
std::uint64_t usual_gap(const Flow& flow) {
  return std::clamp(tools::nominal(flow.median_gap()), flow.shortest_gap(), flow.longest_gap());
}

}  // namespace

namespace {

/// For a periodic flow: the rates with such Periods that its cycle has no event which a gate would
/// count as missing. A gate does that from 1.5 Periods on.
std::vector<Rate> rates_of_cycle(const Flow& flow, const std::vector<Rate>& rates) {
  const std::uint64_t median = flow.median_gap();
  const std::uint64_t shortest =
      std::clamp(flow.longest_of_one() * 20 / 29, median * 3 / 4, median * 98 / 100);
  std::vector<Rate> out;
  std::ranges::copy_if(rates, std::back_inserter(out),
                       [&](const Rate& rate) { return rate.period >= shortest; });
  return out;
}

struct Chosen {
  Rate rate;
  bool on_events = false;
};

/// Chooses a rate for a cycle of which all rates are given. If no event is early by more than half
/// a cycle, and they keep it in the long run, that is its rate. Otherwise there are events in
/// between: then it is the longest Period at which they do not accumulate, which is a little
/// shorter than the cycle, because with the cycle itself each would count for ever.
std::optional<Chosen> rate_of_cycle(const Flow& flow, const std::vector<Rate>& all) {
  const std::vector<Rate> rates = rates_of_cycle(flow, all);
  const std::uint64_t median = flow.median_gap();
  const std::uint64_t cycle = longest_cycle(flow);
  for (const Rate& rate : rates)
    if (rate.early <= rate.period / 2 && (rate.period <= cycle || &rate == &rates.back()))
      return Chosen{rate, false};
  if (rates.empty() || rates.back().early > rates.back().period * kBurst) return std::nullopt;
  const std::uint64_t least = rates.back().early;
  const std::uint64_t kept = shortest_mean(flow);
  for (const Rate& rate : rates)
    if (rate.early <= least + rate.period / 2 && rate.period <= std::min(median * 99 / 100, kept))
      return Chosen{rate, true};
  return Chosen{rates.back(), true};
}

/// The longest Period of at most `longest` (ns) that all events kept, if a burst may be early by
/// `at_once` Periods.
Rate rate_of_others(const std::vector<Rate>& rates, std::uint64_t longest, std::uint64_t at_once) {
  for (const Rate& rate : rates)
    if (rate.period <= longest && rate.early <= rate.period * at_once) return rate;
  return rates.back();
}

/// The Jitter of events at random: what they were early by and a quarter more, or what those to
/// come need (see arrivals.hpp), with a limit.
std::uint64_t jitter_of_others(const Flow& flow, const Rate& rate, std::uint64_t at_once) {
  constexpr std::uint64_t most = 4;  // times as many at once
  const std::uint64_t needed = jitter_of_queue(flow, rate.period);
  const std::uint64_t limit = rate.period * at_once * most;
  return std::max(rate.early + rate.early / 4, needed == UINT64_MAX ? 0 : std::min(needed, limit));
}

Times times_of_one_stamp(const Flow& flow, const TimesOptions& options) {
  Times out;
  out.period = options.assumed_period;
  out.assumed = true;
  out.seen =
      fmt::format("{} events that all have one time stamp: the Period is assumed", flow.events());
  return out;
}

std::string gaps_in_words(const Flow& flow) {
  return fmt::format("{} events, median gap {}, shortest {}, longest {}", flow.events(),
                     about(usual_gap(flow)), about(flow.shortest_gap()), about(flow.longest_gap()));
}

/// The cycle of periodic traffic; `pauses`: what it paused, if at all.
std::optional<Chosen> cycle_of(const Flow& flow, const std::vector<Rate>& rates,
                               const Flow::Pauses& pauses) {
  if (pauses.count != 0) return rate_of_cycle(flow, flow.cyclic_rates());
  if (flow.regular_share() < kRegular || flow.longest_gap() / kFarApart > flow.median_gap())
    return std::nullopt;
  return rate_of_cycle(flow, rates);
}

/// The cycle within bursts, which is none of the time between them.
std::optional<Chosen> cycle_in_bursts(const Flow& flow, const TimesOptions& options) {
  constexpr double regular = 0.6;  // about a third would be of times at random
  if (!options.cycles_of_bursts || pauses_of(flow, kRunOfBurst, regular).count == 0)
    return std::nullopt;
  return rate_of_cycle(flow, flow.cyclic_rates());
}

/// All rates from `longer` (ns) downwards.
std::vector<Rate> with_longer(const Flow& flow, std::uint64_t longer) {
  auto all = flow.all_rates();
  const std::uint64_t most = std::max(longer, flow.rates().front().period);
  std::erase_if(all, [most](const Rate& rate) { return rate.period > most; });
  return all;
}

std::string seen_of(const Times& times, const Flow& flow, std::uint64_t early, bool has_cycle) {
  const std::string gaps = gaps_in_words(flow);
  std::string out;
  if (times.on_events)
    out = fmt::format(
        "cyclic and on events: {}; by this Period the events in between are early by {} + 25 %",
        gaps, about(early));
  else if (times.periodic)
    out = fmt::format("{}; Jitter {} + 25 %", gaps, about(early));
  else if (has_cycle)
    out = fmt::format(
        "aperiodic, in bursts that have a cycle: {}; the Period is that cycle, early by {} + 25 % "
        "at most",
        gaps, about(early));
  else
    out = fmt::format(
        "{}: {}, mean {}; by this Period they were early by {} at most, and the Jitter is for one "
        "of "
        "{} to come earlier",
        times.bursts ? "aperiodic, in bursts" : "aperiodic", gaps, about(flow.mean_gap()),
        about(early), kOneOf);
  if (times.pauses != 0)
    out += fmt::format("; {} no part of its cycle", times.pauses == 1
                                                        ? pauses_in_words(times) + " is"
                                                        : pauses_in_words(times) + ", are");
  return out;
}

}  // namespace

std::string seen_in_words(const Flow& flow) {
  if (flow.events() < 2) return "seen once";
  return flow.gaps() + 1 < Flow::kFirst ? fmt::format("seen {} times, {} apart at least",
                                                      flow.events(), about(flow.shortest_gap()))
                                        : gaps_in_words(flow);
}

bool says_what_was_seen(std::string_view comment) {
  return comment.contains(" events, median gap ") || comment.contains("seen once") ||
         (comment.contains("seen ") && comment.contains(" times")) ||
         comment.contains(" events that all have one time stamp");
}

Times times_of(const Flow& flow, const Timeline& timeline, const TimesOptions& options) {
  if (flow.gaps() != 0 && flow.longest_gap() == 0) return times_of_one_stamp(flow, options);
  const auto rates = flow.rates();
  if (rates.empty()) return times_of_few(flow, timeline, options);
  constexpr std::uint64_t longest_burst = 1'000'000'000;  // ns, of what looks cyclic
  const std::uint64_t longer = period_of_bursts(flow, timeline, rates.front().period, options);
  const bool is_burst = longer > rates.front().period;
  const bool is_one_burst = is_burst && flow.active() < longest_burst;
  const Flow::Pauses pauses = pauses_of(flow, kRun);
  const auto cycle = is_one_burst ? std::nullopt : cycle_of(flow, rates, pauses);
  const auto in_bursts = cycle ? std::nullopt : cycle_in_bursts(flow, options);
  Times out;
  out.periodic = cycle.has_value();
  out.on_events = cycle && cycle->on_events;
  out.bursts = !out.periodic && (in_bursts || is_burst || flow.comes_in_bursts());
  if (out.periodic && pauses.count != 0) {
    out.pauses = pauses.count;
    out.longest_pause = flow.longest_gap();
  }
  Rate chosen;
  if (cycle || in_bursts) {
    chosen = cycle ? cycle->rate : in_bursts->rate;
    out.jitter = chosen.early == 0 ? 0 : with_margin(chosen.early, 25);
  } else {
    chosen = is_burst ? rate_of_others(with_longer(flow, longer), longer, options.at_once)
                      : rate_of_others(rates, longest_period(flow), options.at_once);
    out.jitter = rounded_up(jitter_of_others(flow, chosen, options.at_once));
  }
  out.period = chosen.period;
  out.seen = seen_of(out, flow, chosen.early, in_bursts.has_value());
  return out;
}

std::uint64_t omission_of(const Flow& flow, std::uint64_t period) {
  period = std::max<std::uint64_t>(period, 1);
  const std::uint64_t periods = (pauses_of(flow, kRun).longest_other + period / 2) / period;
  return periods == 0 ? 0 : periods - 1;
}

// --- channels ------------------------------------------------------------------------------------

namespace {

/// The key of a channel: its number on one CAN interface, or its subject on all Ethernets.
using Key = std::pair<std::uint32_t, std::uint64_t>;
constexpr std::uint32_t kAnyEthernet = UINT32_MAX;  // replaces the interface

class Collector {
 public:
  Collector(const Observer& observer, const TimesOptions& options)
      : observer_(observer), options_(options) {}

  std::vector<Channel> run() {
    for (const auto& [key, seen] : observer_.flows())
      if (seen.origin) crossing_.insert({key, *seen.origin});
    for (const auto& [key, seen] : observer_.flows())
      if (is_followed(key)) number_of(key_of(key));
    for (const auto& [key, seen] : observer_.flows())
      if (is_followed(key) && seen.origin) join(key);
    for (const auto& [key, seen] : observer_.flows())
      if (is_followed(key)) put(key, seen);
    std::vector<Channel> out;
    for (auto& [group, channel] : channels_)
      if (!channel.sources.empty()) out.push_back(std::move(channel));
    std::ranges::sort(out, {}, [](const Channel& c) { return std::pair(c.interface, c.number); });
    return out;
  }

 private:
  /// Whether a flow belongs to a channel. Control traffic does only if it crosses the gateway.
  [[nodiscard]] bool is_followed(const FlowKey& key) const {
    if (observer_.flows().at(key).control && !crossing_.contains(key)) return false;
    return !observer_.is_ethernet(key.interface) ||
           core::has_datagrams(observer_.profile_of(key.interface));
  }
  [[nodiscard]] Key key_of(const FlowKey& key) const {
    return {observer_.is_ethernet(key.interface) ? kAnyEthernet : key.interface, key.number};
  }

  std::size_t number_of(const Key& key) {
    const auto [known, fresh] = numbers_.try_emplace(key, groups_.size());
    if (fresh) {
      groups_.emplace_back().emplace(key.first, key.second);
      parents_.push_back(known->second);
    }
    return known->second;
  }
  std::size_t root(std::size_t at) {
    while (parents_[at] != at) at = parents_[at] = parents_[parents_[at]];
    return at;
  }

  /// Joins the channel of a copy with the one of its origin, unless a network then had two numbers
  /// of it.
  void join(const FlowKey& copy) {
    const FlowKey& origin = *observer_.flows().at(copy).origin;
    if (!is_followed(origin)) return;
    std::size_t to = root(number_of(key_of(origin)));
    std::size_t from = root(number_of(key_of(copy)));
    if (to != from) {
      if (groups_[to].size() < groups_[from].size()) std::swap(to, from);
      for (const auto& [interface, number] : groups_[from])
        if (groups_[to].contains(interface)) return;
      groups_[to].merge(groups_[from]);
      parents_[from] = to;
    }
    joined_.insert(copy);
  }

  /// Whether a flow is a copy of another flow that began somewhere, perhaps over several
  /// interfaces.
  [[nodiscard]] bool is_copy(const FlowKey& key) const {
    constexpr int most_interfaces = 64;
    const FlowKey* at = &key;
    for (int i = 0; i < most_interfaces; ++i) {
      const Seen& seen = observer_.flows().at(*at);
      if (!seen.origin || !joined_.contains(*at)) return at != &key;
      at = &*seen.origin;
    }
    return false;  // copies in a circle have no beginning
  }

  void put(const FlowKey& key, const Seen& seen) {
    Channel& channel = channels_[root(number_of(key_of(key)))];
    if (observer_.is_ethernet(key.interface)) channel.subject = key.number;
    InterfaceTraffic& place = channel.places[key.interface];
    place.number = key.number;
    place.fd = place.fd || seen.fd != 0;
    place.classic = place.classic || seen.fd < seen.flow.events();
    place.remote = place.remote || seen.remote != 0;
    place.priorities.insert(seen.priorities.begin(), seen.priorities.end());
    if (is_copy(key)) {
      if (place.crossing && place.crossing->events > seen.crossing.events) return;
      place.crossing = seen.crossing;
      place.renumbered = seen.renumbered;
      place.node = key.node;
      return;
    }
    place.local = place.local || key.local;
    if (channel.sources.empty()) {
      channel.interface = key.interface;
      channel.number = key.number;
    }
    add_source(channel,
               {key, &seen,
                times_of(seen.flow, observer_.interfaces()[key.interface].timeline, options_)});
  }

  /// The node number of a program of this host; nullopt on Ethernet and if the profile has no
  /// nodes.
  [[nodiscard]] std::optional<std::uint32_t> node_of(const FlowKey& key) const {
    return observer_.has_nodes(key.interface) ? std::optional(key.node) : std::nullopt;
  }
  /// Adds a publisher. Programs of this host that have no different nodes are one publisher on all
  /// interfaces.
  void add_source(Channel& channel, Source source) const {
    if (source.key.local)
      for (Source& other : channel.sources)
        if (other.key.local && node_of(other.key) == node_of(source.key)) {
          if (other.times.period > source.times.period) std::swap(other, source);
          other.times.jitter = std::max(other.times.jitter, source.times.jitter);
          return;
        }
    channel.sources.push_back(std::move(source));
  }

  const Observer& observer_;
  const TimesOptions& options_;
  std::map<Key, std::size_t> numbers_;
  /// Joined channels: their numbers by interface, or kAnyEthernet. A channel has one number on each
  /// bus, and one subject on all Ethernets.
  std::vector<std::map<std::uint32_t, std::uint64_t>> groups_;
  std::vector<std::size_t> parents_;
  std::set<FlowKey> joined_;
  std::set<FlowKey> crossing_;  ///< flows that cross the gateway, and those from which they come
  std::map<std::size_t, Channel> channels_;  ///< by group
};

}  // namespace

std::vector<Channel> channels_of(const Observer& observer, const TimesOptions& options) {
  return Collector(observer, options).run();
}

}  // namespace mlcca::learn
