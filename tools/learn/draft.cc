// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/draft.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/number.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"
#include "tools/escape.hpp"

namespace mlcca::learn {
namespace {

using core::Profile;

constexpr std::uint32_t kAssumedBitrate = 500'000;  // bit/s, where none is stated
constexpr std::uint64_t kAssumedLatency =
    1'000'000;                           // ns that forwarding takes, where none was seen
constexpr double kRegular = 0.9;         // share of gaps near the median, of what is periodic
constexpr std::uint64_t kBurst = 8;      // events at once, of what is aperiodic
constexpr double kCopied = 0.9;          // share of events that came from there, of what crosses
constexpr std::uint64_t kFarApart = 10;  // longest gap over the median, of what is aperiodic

/// Up to two digits.
std::uint64_t rounded_up(std::uint64_t value) {
  std::uint64_t unit = 1;
  while (value / unit >= 100) unit *= 10;
  return (value + unit - 1) / unit * unit;
}

/// To three digits, for people.
std::string about(std::uint64_t ns) {
  std::uint64_t unit = 1;
  while (ns / unit >= 1000) unit *= 10;
  return tools::time_words((ns + unit / 2) / unit * unit);
}

std::uint64_t with_margin(std::uint64_t value, unsigned percent) {
  return rounded_up(value + value * percent / 100);
}

/// What is stated of the times of a flow.
struct Times {
  std::uint64_t period = 0;
  std::uint64_t jitter = 0;
  bool periodic = false;
  std::string seen;  ///< in words, with the margin
};

Times times_of(const Flow& flow) {
  Times out;
  const auto rates = flow.rates();
  if (rates.empty()) {
    out.period = flow.events() < 2
                     ? tools::kPeriodOfOne
                     : std::max<std::uint64_t>(tools::nominal(flow.shortest_gap() / 2), 1000);
    out.seen =
        flow.events() < 2
            ? std::string("seen once: the Period is assumed")
            : fmt::format("seen {} times only, {} apart at least: the Period is half of that",
                          flow.events(), about(flow.shortest_gap()));
    return out;
  }
  const std::uint64_t median = flow.median_gap();
  out.periodic = flow.regular_share() >= kRegular && flow.longest_gap() / kFarApart <= median;
  // The gate lets events be early by one Period and the Jitter.
  const auto fits = [&](const Rate& rate) {
    return rate.early <= (out.periodic ? rate.period / 2 : rate.period * kBurst);
  };
  auto chosen = std::ranges::find_if(rates, fits);
  if (chosen == rates.end()) chosen = std::prev(rates.end());
  out.period = chosen->period;
  out.jitter = chosen->early == 0 ? 0 : with_margin(chosen->early, 25);
  if (out.periodic)
    out.seen = fmt::format("{} events, median gap {}, shortest {}, longest {}; Jitter {} + 25 %",
                           flow.events(), about(tools::nominal(median)), about(flow.shortest_gap()),
                           about(flow.longest_gap()), about(chosen->early));
  else
    out.seen = fmt::format(
        "aperiodic: {} events, median gap {}, shortest {}, longest {}; the Period is the one that "
        "all "
        "of them kept, early by {} + 25 % at most",
        flow.events(), about(tools::nominal(median)), about(flow.shortest_gap()),
        about(flow.longest_gap()), about(chosen->early));
  return out;
}

/// Events that were lost in a row at most.
std::uint64_t omission_of(const Flow& flow) {
  const std::uint64_t median = std::max<std::uint64_t>(flow.median_gap(), 1);
  const std::uint64_t periods = (flow.longest_gap() + median / 2) / median;
  return periods == 0 ? 0 : periods - 1;
}

/// One publisher of a channel.
struct Source {
  FlowKey key;
  const Seen* seen = nullptr;
  Times times;
};

/// A channel that begins on an interface.
struct Channel {
  std::uint32_t interface = 0;
  std::uint32_t number = 0;
  std::vector<Source> sources;
  std::map<std::uint32_t, Crossing> to;                 ///< where copies were seen
  std::map<std::uint32_t, std::uint32_t> number_there;  ///< of the copies
};

class Drafter {
 public:
  Drafter(const Observer& observer, const std::vector<std::string>& names,
          const DraftOptions& options)
      : observer_(observer), names_(names), options_(options) {}

  Draft run() {
    for (const std::string& name : names_) {
      const auto described = options_.networks.find(name);
      std::string network =
          described == options_.networks.end() ? tools::name_like(name) : described->second;
      while (!used_.insert(network).second) network += "-2";
      networks_.push_back(network);
    }
    collect();
    write();
    return std::move(out_);
  }

 private:
  [[nodiscard]] Profile profile_of(std::uint32_t interface) const {
    return observer_.interfaces()[interface].recognised->profile;
  }

  /// Where most of the events of a flow had been before; nothing: they begin here.
  [[nodiscard]] static std::optional<std::uint32_t> origin_of(const Seen& seen) {
    for (const auto& [interface, crossing] : seen.from)
      if (static_cast<double>(crossing.events) >=
              kCopied * static_cast<double>(seen.flow.events()) &&
          seen.flow.events() >= 3)
        return interface;
    return std::nullopt;
  }

  /// The flow that a copy is of, over several interfaces where it began; the flow itself, if it is
  /// no copy.
  [[nodiscard]] const std::pair<const FlowKey, Seen>& beginning_of(
      const std::pair<const FlowKey, Seen>& flow) const {
    constexpr int most_interfaces = 8;
    const auto* at = &flow;
    for (int i = 0; i < most_interfaces; ++i) {
      const auto origin = origin_of(at->second);
      if (!origin) break;
      FlowKey key = at->first;
      key.interface = *origin;
      key.local = false;
      auto before = observer_.flows().find(key);
      key.local = true;
      if (before == observer_.flows().end()) before = observer_.flows().find(key);
      if (before == observer_.flows().end()) break;
      at = &*before;
    }
    return *at;
  }

  void collect() {
    for (const auto& [key, seen] : observer_.flows()) {
      if (origin_of(seen)) continue;
      Channel& channel = channels_[{key.interface, key.number}];
      channel.interface = key.interface;
      channel.number = key.number;
      channel.sources.push_back({key, &seen, times_of(seen.flow)});
    }
    for (const auto& flow : observer_.flows()) {
      const auto& [key, seen] = flow;
      const auto& begins = beginning_of(flow);
      const auto channel = channels_.find({begins.first.interface, begins.first.number});
      if (&begins == &flow || channel == channels_.end()) continue;
      const auto most = std::ranges::max_element(seen.from, {},
                                                 [](const auto& one) { return one.second.events; });
      channel->second.to[key.interface] = most->second;
      channel->second.number_there[key.interface] = key.number;
    }
  }

  void write() {
    for (auto& [key, channel] : channels_) describe(channel);
    std::string channels;
    std::string ends;
    for (const DraftChannel& row : out_.channels) {
      channels += row.channel_xml;
      for (const std::string& publisher : row.publisher_xml) ends += publisher;
      ends += row.subscriber_xml;
    }
    std::string& xml = out_.xml;
    xml =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<!--\n"
        "  Drafted from traffic by mlccactl learn. Each channel says what was seen, and which "
        "margin\n"
        "  was added. Read it before you use it: what is wrong on the bus now is described here, "
        "too.\n"
        "-->\n";
    xml += fmt::format("<System name=\"{}\">\n", options_.system);
    xml += channels;
    for (std::uint32_t i = 0; i < networks_.size(); ++i) write_network(i);
    if (!networks_.empty()) write_gateway();
    xml += ends;
    xml += "</System>\n";
  }

  /// What the flows of a channel have together.
  struct Together {
    bool fd = false;
    bool classic = false;
    bool remote = false;
    std::set<std::uint32_t> priorities;
    std::string seen;  ///< of the first publisher, in words
  };
  static Together put_together(const Channel& channel, DraftChannel& row) {
    Together out;
    row.periodic = true;
    row.period = UINT64_MAX;
    for (const Source& source : channel.sources) {
      const Flow& flow = source.seen->flow;
      row.events += flow.events();
      row.period = std::min(row.period, source.times.period);
      row.jitter = std::max(row.jitter, source.times.jitter);
      row.median = row.median == 0 ? flow.median_gap() : std::min(row.median, flow.median_gap());
      row.longest_gap = std::max(row.longest_gap, flow.longest_gap());
      row.bytes = std::max(row.bytes, flow.most_bytes());
      row.periodic = row.periodic && source.times.periodic;
      if (source.times.periodic) row.omission = std::max(row.omission, omission_of(flow) + 1);
      out.fd = out.fd || source.seen->fd != 0;
      out.classic = out.classic || source.seen->fd < flow.events();
      out.remote = out.remote || source.seen->remote != 0;
      out.priorities.insert(source.seen->priorities.begin(), source.seen->priorities.end());
      if (out.seen.empty()) out.seen = source.times.seen;
    }
    if (!row.periodic) row.omission = 0;
    return out;
  }

  void describe(const Channel& channel) {
    DraftChannel row;
    const Profile profile = profile_of(channel.interface);
    row.name = tools::channel_name(profile, networks_[channel.interface], channel.number);
    row.interface = names_[channel.interface];
    row.number = channel.number;
    row.identifier = tools::number_text(profile, channel.number);
    const Together together = put_together(channel, row);
    shortest_period_ = std::min(shortest_period_, row.period);
    std::string comment = together.seen;
    if (channel.sources.size() > 1)
      comment += fmt::format("; the first of {} publishers", channel.sources.size());
    if (row.periodic) comment += fmt::format("; {} lost in a row at most, + 1", row.omission - 1);
    row.channel_xml = fmt::format(
        "  <!-- {} -->\n  <EventChannel name=\"{}\">\n    <SubjectUID>0x{:016x}</SubjectUID>\n"
        "    <Attributes period=\"{}\"{} maxPayload=\"{}\"/>\n  </EventChannel>\n",
        comment, row.name, tools::subject_of(row.name), tools::time_words(row.period),
        row.periodic ? fmt::format(R"( omission="{}")", row.omission) : "",
        std::max(row.bytes, 1U));
    bind(row, channel.interface, channel.number, together);
    for (const auto& [interface, crossing] : channel.to) {
      bind(row, interface, channel.number_there.at(interface), together);
      row.crosses_to.push_back(names_[interface]);
      longest_crossing_ = std::max(longest_crossing_, crossing.longest_ns);
    }
    for (const Source& source : channel.sources) write_publisher(row, channel, source);
    write_subscribers(row, channel);
    out_.channels.push_back(std::move(row));
  }

  void bind(DraftChannel& row, std::uint32_t interface, std::uint32_t number,
            const Together& together) {
    const Profile profile = profile_of(interface);
    const bool has_priority = core::traits_of(profile).has_number_priority;
    const auto priority = has_priority && together.priorities.size() == 1
                              ? std::optional(*together.priorities.begin())
                              : std::nullopt;
    std::string format;
    if (together.fd) format = together.classic ? R"( format="any")" : R"( format="fd")";
    row.binding_xml[names_[interface]] =
        fmt::format("    <Binding channel=\"{}\"{}{}>{}</Binding>\n", row.name, format,
                    together.remote ? R"( remote-frames="true")" : "",
                    tools::binding_element(profile, number, priority));
    if (together.fd) fd_[interface] = true;
  }

  void write_publisher(DraftChannel& row, const Channel& channel, const Source& source) {
    const Profile profile = profile_of(channel.interface);
    const std::string& network = networks_[channel.interface];
    std::string name = row.name;
    std::string where = source.key.local
                            ? fmt::format(R"(gateway="{}" user="{}")", options_.gateway,
                                          tools::escaped(options_.user))
                            : fmt::format("network=\"{}\"", network);
    if (core::has_nodes(profile)) {
      name += fmt::format("-of-{:02X}", source.key.node);
      where += fmt::format(R"( node="{}")", source.key.node);
    } else if (source.key.local) {
      name += "-here";
    }
    if (core::traits_of(profile).has_sender_priority && !source.seen->priorities.empty())
      where += fmt::format(R"( priority="{}")", *source.seen->priorities.begin());
    row.publishers.push_back(name);
    row.nodes.push_back(source.key.node);
    std::string& text = row.publisher_xml.emplace_back();
    text = fmt::format(R"(  <Publisher name="{}" channel="{}" {})", name, row.name, where);
    std::string own;
    if (source.times.period != row.period)
      own += fmt::format(" period=\"{}\"", tools::time_words(source.times.period));
    if (source.times.jitter != 0)
      own += fmt::format(" jitter=\"{}\"", tools::time_words(source.times.jitter));
    text += own.empty() ? "/>\n" : fmt::format(">\n    <Attributes{}/>\n  </Publisher>\n", own);
  }

  void write_subscribers(DraftChannel& row, const Channel& channel) {
    for (const auto& [interface, crossing] : channel.to)
      row.subscriber_xml += fmt::format(
          "  <!-- its frames were there {} to {} later -->\n"
          "  <Subscriber channel=\"{}\" network=\"{}\"/>\n",
          about(crossing.shortest_ns), about(crossing.longest_ns), row.name, networks_[interface]);
    const bool all_local =
        std::ranges::all_of(channel.sources, [](const Source& s) { return s.key.local; });
    if (all_local && channel.to.empty())
      row.subscriber_xml += fmt::format("  <Subscriber channel=\"{}\" network=\"{}\"/>\n", row.name,
                                        networks_[channel.interface]);
    else if (options_.local_subscribers && !all_local)
      row.subscriber_xml += fmt::format("  <Subscriber channel=\"{}\" gateway=\"{}\"/>\n", row.name,
                                        options_.gateway);
  }

  void write_network(std::uint32_t interface) {
    const auto& of = observer_.interfaces()[interface];
    const std::string& name = names_[interface];
    const auto stated = options_.bitrates.find(name);
    const std::uint32_t bitrate =
        stated == options_.bitrates.end() ? kAssumedBitrate : stated->second;
    const auto data = options_.data_bitrates.find(name);
    std::string& xml = out_.xml;
    xml += fmt::format(
        "  <!-- {}: {} frames; profile {}, {} % sure: {} -->\n", tools::in_comment(name), of.frames,
        tools::profile_word(of.recognised->profile), of.recognised->percent, of.recognised->why);
    xml += fmt::format("  <Network name=\"{}\">\n    <Kind>can</Kind>\n    <Profile>{}</Profile>\n",
                       networks_[interface], tools::profile_word(of.recognised->profile));
    if (stated == options_.bitrates.end())
      xml += "    <!-- The bit rate is assumed: state the real one. -->\n";
    std::string data_rate;
    if (data != options_.data_bitrates.end())
      data_rate = fmt::format(" data-bitrate=\"{}\"", data->second);
    else if (fd_[interface])
      data_rate = fmt::format(" data-bitrate=\"{}\"", bitrate);
    xml += fmt::format("    <Bus bitrate=\"{}\"{}/>\n", bitrate, data_rate);
    xml += "    <Provision omission=\"0\" packetLoss=\"0\"/>\n";
    for (const DraftChannel& row : out_.channels)
      if (const auto bound = row.binding_xml.find(name); bound != row.binding_xml.end())
        xml += bound->second;
    xml += "  </Network>\n";
    if (of.unfollowed != 0)
      out_.left_out.push_back(
          fmt::format("{}: {} events of further identifiers: {} are followed at most", name,
                      of.unfollowed, Observer::kMostFlows));
    if (of.decoder->other_frames() != 0)
      out_.left_out.push_back(fmt::format("{}: {} frames that no channel of profile {} can have",
                                          name, of.decoder->other_frames(),
                                          tools::profile_word(of.recognised->profile)));
  }

  void write_gateway() {
    const std::uint64_t latency =
        longest_crossing_ == 0 ? kAssumedLatency : with_margin(longest_crossing_, 50);
    const std::uint64_t period =
        shortest_period_ == UINT64_MAX ? kAssumedLatency : shortest_period_;
    std::string& xml = out_.xml;
    xml += longest_crossing_ == 0 ? "  <!-- Nothing crossed it: its Latency is assumed. -->\n"
                                  : fmt::format("  <!-- Frames took {} at most, + 50 %. -->\n",
                                                about(longest_crossing_));
    xml += fmt::format("  <Gateway name=\"{}\">\n", options_.gateway);
    xml += fmt::format(
        "    <Provision latency=\"{0}\" jitter=\"{0}\" period=\"{1}\" omission=\"0\" "
        "packetLoss=\"0\" "
        "maxPayload=\"65535\"/>\n",
        tools::time_words(latency), tools::time_words(period));
    std::set<std::string> used;
    for (std::uint32_t i = 0; i < networks_.size(); ++i) {
      constexpr std::size_t stem = 11;
      std::string interface = tools::interface_like(names_[i]);
      // Names of a recording that are none of interfaces may become alike.
      for (unsigned number = 2; !used.insert(interface).second; ++number)
        interface = fmt::format("{}-{}", tools::interface_like(names_[i]).substr(0, stem), number);
      xml += fmt::format("    <Port network=\"{}\"><Interface name=\"{}\"/></Port>\n", networks_[i],
                         interface);
    }
    xml += "  </Gateway>\n";
  }

  const Observer& observer_;
  const std::vector<std::string>& names_;
  const DraftOptions& options_;
  std::vector<std::string> networks_;
  std::set<std::string> used_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Channel> channels_;
  std::map<std::uint32_t, bool> fd_;
  std::uint64_t shortest_period_ = UINT64_MAX;
  std::uint64_t longest_crossing_ = 0;
  Draft out_;
};

}  // namespace

Draft draft_of(const Observer& observer, const std::vector<std::string>& names,
               const DraftOptions& options) {
  return Drafter(observer, names, options).run();
}

}  // namespace mlcca::learn
