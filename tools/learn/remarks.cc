// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/remarks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <set>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"
#include "tools/learn/channels.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostNamed = 8;                  // channels in a line
constexpr std::uint64_t kManyGaps = 10;                // in gaps of a channel
constexpr std::uint64_t kShortestEnd = 1'000'000'000;  // ns
// The times of a bus are doubtful if so many events, and one of so many, come too soon after
// another of the same identifier.
constexpr std::uint64_t kFewestClose = 8;
constexpr std::uint64_t kCloseOf = 200;

class Remarks {
 public:
  Remarks(const Observer& observer, const std::vector<std::string>& names, bool drafts_networks)
      : observer_(observer), names_(names), drafts_networks_(drafts_networks) {}

  std::vector<std::string> run() {
    for (std::uint32_t i = 0; i < names_.size(); ++i) {
      profile(i);
      transport(i);
      ends(i);
      pauses(i);
      stamps(i);
      times(i);
      services(i);
    }
    return std::move(out_);
  }

 private:
  using Numbers = std::vector<std::string>;

  [[nodiscard]] const Observer::Interface& at(std::uint32_t interface) const {
    return observer_.interfaces()[interface];
  }
  [[nodiscard]] std::string number_of(const FlowKey& key) const {
    return observer_.is_ethernet(key.interface)
               ? core::format_subject(key.number)
               : tools::number_text(observer_.profile_of(key.interface),
                                    static_cast<std::uint32_t>(key.number));
  }
  /// The numbers of the flows of an interface that have channels and for which `is` is true.
  template <class Is>
  [[nodiscard]] Numbers numbers(std::uint32_t interface, const Is& is) const {
    Numbers out;
    if (observer_.is_ethernet(interface) && !core::has_datagrams(observer_.profile_of(interface)))
      return out;
    for (const auto& [key, seen] : observer_.flows()) {
      if (key.interface != interface || seen.control || !is(key, seen)) continue;
      const std::string number = number_of(key);
      if (out.empty() || out.back() != number) out.push_back(number);
    }
    return out;
  }
  static std::string listed(const Numbers& all) {
    const auto shown = std::min(all.size(), kMostNamed);
    return fmt::format("{}{}", fmt::join(all.begin(), all.begin() + static_cast<int>(shown), ", "),
                       all.size() == shown ? "" : fmt::format(" and {} more", all.size() - shown));
  }

  void profile(std::uint32_t interface) {
    const auto& perhaps = at(interface).recognised->perhaps;
    if (perhaps)
      out_.push_back(
          fmt::format("{0}: it may be {1}, which is not certain: if it is, state --profile {0}={1}",
                      names_[interface], tools::profile_word(*perhaps)));
  }

  /// Notes a network of Ethernet whose Kind is assumed, and the subjects that it does not carry.
  void transport(std::uint32_t interface) {
    if (!drafts_networks_ || !observer_.is_ethernet(interface)) return;
    const Transports& transports = at(interface).datagrams->transports();
    const auto kind = core::words::kNetworkKinds.of(transports.most());
    if (transports.all() == 0) {
      out_.push_back(fmt::format("{}: no event was seen there: its Kind {} is assumed",
                                 names_[interface], kind));
      return;
    }
    const std::uint64_t others = transports.missed_by(transports.most());
    if (others == 0) return;
    const bool is_broadcast = transports.most() == core::NetworkKind::udp_broadcast;
    const Numbers missed = numbers(interface, [&](const FlowKey&, const Seen& seen) {
      return is_broadcast ? seen.broadcasts != seen.flow.events() : seen.broadcasts != 0;
    });
    out_.push_back(fmt::format(
        "{}: {} of {} with events are of {}, the others of {}: {} is assumed, by which nobody "
        "receives all of {}",
        names_[interface], others, many(transports.all(), "datagram"),
        transport_word(!is_broadcast), transport_word(is_broadcast), kind,
        missed.empty() ? "them" : listed(missed)));
  }

  /// Notes channels that were present only part of the time: that may be a fault, or a state of the
  /// plant.
  void ends(std::uint32_t interface) {
    const Timeline& timeline = at(interface).timeline;
    const auto is_long = [](const Flow& flow, std::uint64_t ns) {
      return ns >= kShortestEnd && ns / kManyGaps >= flow.median_gap() &&
             ns / 2 >= flow.longest_gap();
    };
    const Numbers ended = numbers(interface, [&](const FlowKey&, const Seen& seen) {
      const Flow& flow = seen.flow;
      return flow.last_clock() == timeline.clock() && timeline.last() > flow.last() &&
             is_long(flow, timeline.last() - flow.last()) && times_of(flow, timeline).periodic;
    });
    if (!ended.empty())
      out_.push_back(fmt::format(
          "{}: nothing more came of {} while others went on: the draft expects {} to go "
          "on, too",
          names_[interface], listed(ended), ended.size() == 1 ? "it" : "them"));
    const Numbers begun = numbers(interface, [&](const FlowKey&, const Seen& seen) {
      const Flow& flow = seen.flow;
      return flow.first_clock() == 0 && flow.first() > timeline.first() &&
             is_long(flow, flow.first() - timeline.first()) && times_of(flow, timeline).periodic;
    });
    if (!begun.empty())
      out_.push_back(fmt::format("{}: {} began only when others had been there for long",
                                 names_[interface], listed(begun)));
  }

  /// Notes channels whose silence a gate reports, although it may be as it should be.
  void pauses(std::uint32_t interface) {
    const Timeline& timeline = at(interface).timeline;
    const Numbers all = numbers(interface, [&](const FlowKey&, const Seen& seen) {
      const Times times = times_of(seen.flow, timeline);
      return times.periodic && times.pauses != 0;
    });
    if (!all.empty())
      out_.push_back(fmt::format(
          "{}: {} paused while others went on: the draft has {} cycle, so {} subscribers get an "
          "exception when {} {}",
          names_[interface], listed(all), all.size() == 1 ? "its" : "their",
          all.size() == 1 ? "its" : "their", all.size() == 1 ? "it" : "they",
          all.size() == 1 ? "pauses" : "pause"));
  }

  /// Notes a bus whose frames have times closer to each other than any bus can carry frames: who
  /// recorded them has given them times later. Frames of several identifiers may be read at once,
  /// somewhat later than they came; but if one identifier comes again at once, its times are lost.
  void times(std::uint32_t interface) {
    if (at(interface).medium != Medium::can) return;
    std::uint64_t gaps = 0;
    std::uint64_t close = 0;
    for (const auto& [key, seen] : observer_.flows()) {
      if (key.interface != interface) continue;
      gaps += seen.flow.gaps();
      close += seen.flow.gaps_below(Timeline::kTooClose);
    }
    if (close < kFewestClose || close * kCloseOf < gaps) return;
    const auto percent = [](std::uint64_t part, std::uint64_t all) {
      return all == 0 ? 0 : (part * 100 + all / 2) / all;
    };
    const std::uint64_t frames = at(interface).frames;
    out_.push_back(fmt::format(
        "{}: the times are not those of the bus: {} % of {} frames are within {} of the one "
        "before, and {} % of the events within {} of the one before with the same identifier, "
        "which no bus can carry. The recorder has made them up, or has lost frames: do not rely "
        "on the Periods and Jitters of this draft",
        names_[interface], percent(at(interface).timeline.too_close(), frames), frames,
        about(Timeline::kTooClose), percent(close, gaps), about(Timeline::kTooClose)));
  }

  void stamps(std::uint32_t interface) {
    const Numbers alike = numbers(interface, [](const FlowKey&, const Seen& seen) {
      return seen.flow.gaps() != 0 && seen.flow.longest_gap() == 0;
    });
    if (!alike.empty())
      out_.push_back(
          fmt::format("{}: all events of {} have one time stamp: how often they come is "
                      "not known, and the Period is assumed",
                      names_[interface], listed(alike)));
  }

  /// Notes SDOs, which a gate does not pass unless they are described.
  void services(std::uint32_t interface) {
    if (observer_.is_ethernet(interface) ||
        !core::traits_of(observer_.profile_of(interface)).has_services)
      return;
    const Numbers all =
        numbers(interface, [](const FlowKey& key, const Seen&) { return is_service(key.number); });
    if (!all.empty())
      out_.push_back(fmt::format(
          "{}: SDOs were seen ({}): the draft has channels for them, since any entry of a node can "
          "be written by them, and a gate takes them for no control traffic; remove those that "
          "only "
          "a tool needed",
          names_[interface], listed(all)));
  }

  const Observer& observer_;
  const std::vector<std::string>& names_;
  bool drafts_networks_;
  std::vector<std::string> out_;
};

}  // namespace

std::vector<std::string> remarks_on(const Observer& observer, const std::vector<std::string>& names,
                                    bool drafts_networks) {
  return Remarks(observer, names, drafts_networks).run();
}

}  // namespace mlcca::learn
