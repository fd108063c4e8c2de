// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/draft.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "base/many.hpp"
#include "core/gates/plan.hpp"
#include "core/model/medium.hpp"
#include "core/model/station.hpp"
#include "core/model/text.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"
#include "tools/escape.hpp"
#include "tools/learn/channels.hpp"
#include "tools/learn/crossing_remarks.hpp"
#include "tools/learn/remarks.hpp"
#include "tools/learn/senders.hpp"

namespace mlcca::learn {
namespace {

using core::Profile;

constexpr std::uint32_t kAssumedBitrate = 500'000;  // bit/s, where none is stated
constexpr std::uint32_t kFastBitrate = 1'000'000;   // if that cannot carry what was seen
constexpr std::uint32_t kFastDataBitrate = 5'000'000;
constexpr std::uint64_t kAssumedLatency = 1'000'000;  // ns for forwarding, if it was not observed
constexpr std::uint64_t kAssumedEthernet = 100'000;   // ns for an Ethernet

std::string mac_text(const std::array<std::uint8_t, 6>& mac) {
  return fmt::format("{:02x}", fmt::join(mac, ":"));
}

/// The smaller of two times of which 0 says nothing.
std::uint64_t shorter(std::uint64_t a, std::uint64_t b) {
  return a == 0 || b == 0 ? std::max(a, b) : std::min(a, b);
}

class Drafter {
 public:
  Drafter(const Observer& observer, const std::vector<std::string>& names,
          const DraftOptions& options)
      : observer_(observer), names_(names), options_(options) {}

  Draft run() {
    used_.insert(options_.gateway);
    for (const std::string& name : names_) {
      const auto described = options_.networks.find(name);
      networks_.push_back(described == options_.networks.end()
                              ? tools::free_name(used_, tools::name_like(name))
                              : described->second);
      used_.insert(networks_.back());
    }
    channels_ = channels_of(observer_, options_.times);
    out_.left_out = leave_out_senders(observer_, names_, channels_);
    for (const Channel& channel : channels_)
      if (channel.subject) subjects_.insert(*channel.subject);
    write();
    return std::move(out_);
  }

 private:
  void write() {
    for (Channel& channel : channels_) describe(channel);
    std::ranges::move(remarks_on_crossings(observer_, names_, channels_, out_.channels),
                      std::back_inserter(out_.left_out));
    std::ranges::move(remarks_on(observer_, names_, options_.networks.empty()),
                      std::back_inserter(out_.left_out));
    std::string channels;
    std::string ends;
    for (const DraftChannel& row : out_.channels) {
      channels += row.channel_xml;
      for (const DraftPublisher& publisher : row.publishers) ends += publisher.xml;
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

  /// What came in a second of the `events` events of a channel; nullopt: too few to tell.
  [[nodiscard]] std::optional<double> bytes_per_second(const Channel& channel,
                                                       std::uint64_t events) const {
    double sum = 0;
    for (const Source& source : channel.sources) {
      const Timeline& timeline = observer_.interfaces()[source.key.interface].timeline;
      if (!timeline.tells_rate(events)) return std::nullopt;
      sum += static_cast<double>(source.seen->flow.all_bytes()) * 1e9 /
             static_cast<double>(timeline.covered());
    }
    return sum;
  }

  /// Sets the values that the flows of a channel have together: the longest Period of all, because
  /// no subscriber may require a shorter one. Returns the observation of the first flow in words.
  std::string put_together(const Channel& channel, DraftChannel& row) {
    row.periodic = true;
    bool aperiodic = false;
    for (const Source& source : channel.sources) {
      const Flow& flow = source.seen->flow;
      row.events += flow.events();
      row.period = std::max(row.period, source.times.period);
      shortest_period_ = std::min(shortest_period_, source.times.period);
      row.jitter = std::max(row.jitter, source.times.jitter);
      row.gaps.median = shorter(row.gaps.median, flow.median_gap());
      row.gaps.mean = shorter(row.gaps.mean, flow.mean_gap());
      row.gaps.shortest = shorter(row.gaps.shortest, flow.shortest_gap());
      row.gaps.longest = std::max(row.gaps.longest, flow.longest_gap());
      row.gaps.pauses += source.times.pauses;
      row.gaps.longest_pause = std::max(row.gaps.longest_pause, source.times.longest_pause);
      row.bytes = std::max(row.bytes, flow.most_bytes());
      row.bursts = row.bursts || source.times.bursts;
      row.control = row.control || source.seen->control;
      row.periodic = row.periodic && source.times.periodic;
      const bool few = !flow.few().empty();
      row.few = row.few || few;
      aperiodic = aperiodic || !(few || source.times.periodic);
      row.on_events = row.on_events || source.times.on_events;
      if (source.times.periodic)
        row.omission = std::max(row.omission, omission_of(flow, source.times.period) + 1);
    }
    if (!row.periodic) row.omission = 0;
    row.on_events = row.on_events && row.periodic;
    row.bursts = row.bursts && !row.periodic;
    row.few = row.few && !aperiodic;
    row.bytes_per_second = bytes_per_second(channel, row.events);
    row.seen = seen_in_words(channel.sources.front().seen->flow);
    return channel.sources.front().times.seen;
  }

  /// The subject of a channel; only Ethernet frames show it, so others get one that is made from
  /// the name.
  std::uint64_t subject_for(const Channel& channel, const std::string& name) {
    if (channel.subject) return *channel.subject;
    std::string text = name;
    for (;;) {
      const std::uint64_t subject = tools::subject_of(text);
      if (subjects_.insert(subject).second) return subject;
      text += '+';
    }
  }

  void describe(Channel& channel) {
    DraftChannel row;
    const std::string& network = networks_[channel.interface];
    if (observer_.is_ethernet(channel.interface)) {
      row.name = tools::free_name(channel_names_, tools::channel_name(network, channel.number));
      row.identifier = core::format_subject(channel.number);
    } else {
      const Profile profile = observer_.profile_of(channel.interface);
      const auto number = static_cast<std::uint32_t>(channel.number);
      row.name = tools::channel_name(profile, network, number);
      row.identifier = tools::number_text(profile, number);
    }
    row.interface = names_[channel.interface];
    row.subject = channel.subject;
    if (options_.at_mean.contains(row.name)) {
      TimesOptions times = options_.times;
      times.few = OfFew::the_mean;
      for (Source& source : channel.sources)
        source.times = times_of(source.seen->flow,
                                observer_.interfaces()[source.key.interface].timeline, times);
    }
    std::string comment = put_together(channel, row);
    if (channel.sources.size() > 1)
      comment += fmt::format("; the first of {} publishers", channel.sources.size());
    if (row.periodic) comment += fmt::format("; {} lost in a row at most, + 1", row.omission - 1);
    if (!observer_.is_ethernet(channel.interface) &&
        core::traits_of(observer_.profile_of(channel.interface)).has_services &&
        is_service(channel.number))
      comment += "; an SDO, by which any entry of a node can be written: no control traffic";
    if (const auto text = tools::spelled(channel.subject.value_or(0)); !text.empty())
      comment += fmt::format("; its subject is the text {}", tools::in_comment(text));
    std::string deadline;
    if (const auto needed = options_.deadlines.find(row.name); needed != options_.deadlines.end()) {
      deadline = fmt::format(R"( deadline="{}")", tools::time_words(rounded_up(needed->second)));
      comment += "; the Deadline is what its bus can keep with all of this on it, + 25 %";
    }
    row.drafted_subject = subject_for(channel, row.name);
    row.channel_xml = fmt::format(
        "  <!-- {} -->\n  <EventChannel name=\"{}\"{}>\n    <SubjectUID>0x{:016x}</SubjectUID>\n"
        "    <Attributes period=\"{}\"{}{} maxPayload=\"{}\"/>\n  </EventChannel>\n",
        comment, row.name, row.periodic ? "" : R"( arrival="sporadic")", row.drafted_subject,
        tools::time_words(row.period), deadline,
        row.periodic ? fmt::format(R"( omission="{}")", row.omission) : "",
        std::max(row.bytes, 1U));
    for (const auto& [interface, place] : channel.places) {
      row.numbers[names_[interface]] = place.number;
      if (!observer_.is_ethernet(interface)) bind(row, interface, place);
      if (!place.crossing) continue;
      row.crosses_to.push_back(names_[interface]);
      longest_crossing_ = std::max(longest_crossing_, place.crossing->longest_ns);
    }
    write_publishers(row, channel);
    write_subscribers(row, channel);
    out_.channels.push_back(std::move(row));
  }

  void bind(DraftChannel& row, std::uint32_t interface, const InterfaceTraffic& place) {
    const Profile profile = observer_.profile_of(interface);
    const bool has_priority = core::traits_of(profile).has_number_priority;
    const auto priority = has_priority && place.priorities.size() == 1
                              ? std::optional(*place.priorities.begin())
                              : std::nullopt;
    // Longer events than those that were seen there may cross, too.
    const bool fd = place.fd || (row.bytes > core::kClassicBytes &&
                                 core::traits_of(profile).fragmentation == nullptr);
    std::string format;
    if (fd) format = place.classic ? R"( format="any")" : R"( format="fd")";
    row.binding_xml[names_[interface]] = fmt::format(
        "    <Binding channel=\"{}\"{}{}>{}</Binding>\n", row.name, format,
        place.remote ? R"( remote-frames="true")" : "",
        tools::binding_element(profile, static_cast<std::uint32_t>(place.number), priority));
    if (fd) fd_[interface] = true;
  }

  /// A gate distinguishes a limited number of senders of a subject. Those with most events get
  /// their own publisher; one further publisher stands for all others.
  void write_publishers(DraftChannel& row, const Channel& channel) {
    std::map<std::uint32_t, std::vector<std::pair<std::uint64_t, const Source*>>> senders;
    for (const Source& source : channel.sources)
      if (observer_.is_ethernet(source.key.interface) && !source.key.local)
        senders[source.key.interface].emplace_back(source.seen->flow.events(), &source);
    std::set<const Source*> unnamed;
    for (auto& [interface, all] : senders) {
      if (all.size() <= core::kMostEntries) continue;
      std::ranges::stable_sort(all, std::ranges::greater{},
                               [](const auto& one) { return one.first; });
      for (std::size_t i = core::kMostEntries - 1; i < all.size(); ++i)
        unnamed.insert(all[i].second);
      out_.left_out.push_back(
          fmt::format("{}: {} senders of {}: a gate distinguishes {} and takes the others together",
                      names_[interface], all.size(), row.name, core::kMostEntries - 1));
    }
    for (const Source& source : channel.sources)
      write_publisher(row, channel, source, !unnamed.contains(&source));
  }

  /// The node attribute for the buses to which the channel crosses.
  [[nodiscard]] std::string node_beyond(const Channel& channel) const {
    for (const auto& [interface, place] : channel.places) {
      if (!place.crossing || !observer_.has_nodes(interface)) continue;
      std::string out = fmt::format(R"( node="{}")", place.node);
      if (core::traits_of(observer_.profile_of(interface)).has_sender_priority &&
          !place.priorities.empty())
        out += fmt::format(R"( priority="{}")", *place.priorities.begin());
      return out;
    }
    return {};
  }

  void write_publisher(DraftChannel& row, const Channel& channel, const Source& source,
                       bool has_address) {
    const std::uint32_t interface = source.key.interface;
    std::string where = source.key.local
                            ? fmt::format(R"(gateway="{}" user="{}")", options_.gateway,
                                          tools::escaped(options_.user))
                            : fmt::format("network=\"{}\"", networks_[interface]);
    std::string end = source.key.local ? "-here" : "";
    std::string comment;
    if (observer_.has_nodes(interface)) {
      end = fmt::format("-of-{:02X}", source.key.node);
      where += fmt::format(R"( node="{}")", source.key.node);
      if (core::traits_of(observer_.profile_of(interface)).has_sender_priority &&
          !source.seen->priorities.empty())
        where += fmt::format(R"( priority="{}")", *source.seen->priorities.begin());
    } else {
      if (observer_.is_ethernet(interface) && !source.key.local) {
        const std::string address = core::to_text(core::Station{source.key.node});
        end = "-of-" + address;
        if (has_address) where += fmt::format(R"( address="{}")", address);
        if (source.seen->mac != std::array<std::uint8_t, 6>{})
          comment = fmt::format("  <!-- its frames are from {} -->\n", mac_text(source.seen->mac));
      }
      where += node_beyond(channel);
    }
    const std::string name = tools::free_name(publishers_, row.name, end);
    std::string text =
        comment + fmt::format(R"(  <Publisher name="{}" channel="{}" {})", name, row.name, where);
    std::string own;
    if (source.times.period != row.period)
      own += fmt::format(" period=\"{}\"", tools::time_words(source.times.period));
    if (source.times.jitter != 0)
      own += fmt::format(" jitter=\"{}\"", tools::time_words(source.times.jitter));
    text += own.empty() ? "/>\n" : fmt::format(">\n    <Attributes{}/>\n  </Publisher>\n", own);
    const Flow& flow = source.seen->flow;
    row.publishers.push_back({name,
                              names_[interface],
                              source.key.node,
                              source.key.local,
                              source.times.period,
                              source.times.jitter,
                              flow.most_bytes(),
                              source.times.periodic,
                              std::move(text),
                              flow.events(),
                              flow.shorter_events(),
                              flow.least_bytes(),
                              flow.shortest_gap(),
                              flow.all_rates(),
                              {flow.few().begin(), flow.few().end()},
                              source.times.assumed});
  }

  void write_subscribers(DraftChannel& row, const Channel& channel) {
    for (const auto& [interface, place] : channel.places) {
      if (place.crossing)
        row.subscriber_xml += place.crossing->longest_ns == 0
                                  ? "  <!-- a rule of can-gw carries its frames there -->\n"
                                  : fmt::format("  <!-- its frames were there {} to {} later -->\n",
                                                about(place.crossing->shortest_ns),
                                                about(place.crossing->longest_ns));
      if (place.crossing || place.local)
        row.subscriber_xml += fmt::format("  <Subscriber channel=\"{}\" network=\"{}\"/>\n",
                                          row.name, networks_[interface]);
    }
    const bool all_local =
        std::ranges::all_of(channel.sources, [](const Source& s) { return s.key.local; });
    if (options_.local_subscribers && !all_local)
      row.subscriber_xml += fmt::format("  <Subscriber channel=\"{}\" gateway=\"{}\"/>\n", row.name,
                                        options_.gateway);
  }

  void write_network(std::uint32_t interface) {
    const auto& of = observer_.interfaces()[interface];
    const std::string& name = names_[interface];
    out_.xml += fmt::format("  <!-- {}: {} {}; profile {}, {} % sure: {} -->\n",
                            tools::in_comment(name), of.frames, word_for(of.frames, of.medium),
                            tools::profile_word(of.recognised->profile), of.recognised->percent,
                            of.recognised->why);
    for (std::string& note : of.timeline.notes(name, observer_.recordings()))
      out_.left_out.push_back(std::move(note));
    if (of.unfollowed != 0)
      out_.left_out.push_back(fmt::format("{}: {} of further identifiers: {} are followed at most",
                                          name, many(of.unfollowed, "event"),
                                          Observer::kMostFlows));
    if (observer_.is_ethernet(interface))
      write_ethernet(interface);
    else
      write_bus(interface);
  }

  void write_ethernet(std::uint32_t interface) {
    const auto& of = observer_.interfaces()[interface];
    const std::string& name = names_[interface];
    std::string& xml = out_.xml;
    const Transports& transports = of.datagrams->transports();
    out_.transports[name] = transports;
    xml += fmt::format("  <Network name=\"{}\">\n{}    <Kind>{}</Kind>\n", networks_[interface],
                       assumed_kind(transports), core::words::kNetworkKinds.of(transports.most()));
    if (core::has_datagrams(of.recognised->profile))
      xml += fmt::format(
          "    <Profile>famouso</Profile>\n"
          "    <!-- What it provides is assumed: state what your switches do. -->\n"
          "    <Provision latency=\"{0}\" jitter=\"{0}\" period=\"{1}\" omission=\"0\" "
          "packetLoss=\"0\" maxPayload=\"65535\"/>\n",
          tools::time_words(kAssumedEthernet), tools::time_words(provided_period()));
    else
      xml += "    <!-- Without a Profile it has no gate. -->\n";
    xml += "  </Network>\n";
    std::ranges::move(of.datagrams->notes(name), std::back_inserter(out_.left_out));
    if (!core::has_datagrams(of.recognised->profile) && options_.networks.empty())
      out_.left_out.push_back(fmt::format(
          "{0}: its network is drafted without a Profile, so it has no gate: {1}. If it has "
          "FAMOUSO's events, state --profile {0}=famouso",
          name, of.recognised->why));
  }

  /// A comment that the transport is assumed; empty if all events had the same one.
  static std::string assumed_kind(const Transports& transports) {
    if (transports.all() == 0) return "    <!-- Its Kind is assumed: no event was seen. -->\n";
    const std::uint64_t others = transports.missed_by(transports.most());
    if (others == 0) return {};
    const bool is_broadcast = transports.most() == core::NetworkKind::udp_broadcast;
    return fmt::format("    <!-- Its Kind is assumed: {} of {} with events are of {}. -->\n",
                       others, many(transports.all(), "datagram"), transport_word(!is_broadcast));
  }

  void write_bus(std::uint32_t interface) {
    const auto& of = observer_.interfaces()[interface];
    const std::string& name = names_[interface];
    const auto stated = options_.bitrates.find(name);
    const bool fast = options_.fast.contains(name);
    const std::uint32_t assumed = fast ? kFastBitrate : kAssumedBitrate;
    const std::uint32_t bitrate = stated == options_.bitrates.end() ? assumed : stated->second;
    const auto data = options_.data_bitrates.find(name);
    std::string& xml = out_.xml;
    xml += fmt::format("  <Network name=\"{}\">\n    <Kind>can</Kind>\n    <Profile>{}</Profile>\n",
                       networks_[interface], tools::profile_word(of.recognised->profile));
    if (stated == options_.bitrates.end())
      xml += fmt::format("    <!-- The bit rate is assumed{}: state the real one. -->\n",
                         fast ? ", as 500 kbit/s cannot carry this" : "");
    std::string data_rate;
    if (data != options_.data_bitrates.end())
      data_rate = fmt::format(" data-bitrate=\"{}\"", data->second);
    else if (fd_[interface])
      data_rate = fmt::format(" data-bitrate=\"{}\"", fast ? kFastDataBitrate : bitrate);
    xml += fmt::format("    <Bus bitrate=\"{}\"{}/>\n", bitrate, data_rate);
    xml += "    <Provision omission=\"0\" packetLoss=\"0\"/>\n";
    for (const DraftChannel& row : out_.channels)
      if (const auto bound = row.binding_xml.find(name); bound != row.binding_xml.end())
        xml += bound->second;
    xml += "  </Network>\n";
    if (of.decoder->other_frames() != 0)
      out_.left_out.push_back(fmt::format("{}: {} {} that no channel of profile {} can have", name,
                                          of.decoder->other_frames(),
                                          word_for(of.decoder->other_frames(), Medium::can),
                                          tools::profile_word(of.recognised->profile)));
  }

  /// The shortest Period of all channels.
  [[nodiscard]] std::uint64_t provided_period() const {
    return shortest_period_ == UINT64_MAX ? kAssumedLatency : shortest_period_;
  }

  void write_port(std::uint32_t number, const std::string& interface) {
    if (options_.made_up.contains(names_[number]))
      out_.xml +=
          "    <!-- The recording has no name of this interface: state the one that it is. -->\n";
    std::string length;
    if (const auto waiting = options_.waiting.find(names_[number]);
        waiting != options_.waiting.end()) {
      const auto own = options_.queue_lengths.find(names_[number]);
      const std::uint32_t fit = own == options_.queue_lengths.end() ? 0 : own->second;
      if (fit < waiting->second)
        out_.xml += fmt::format(
            "    <!-- So many frames may wait there: ip link set {} txqueuelen {} -->\n",
            tools::in_comment(interface), waiting->second);
      length = fmt::format(" queue-length=\"{}\"", std::max(fit, waiting->second));
    }
    out_.xml += fmt::format("    <Port network=\"{}\"{}><Interface name=\"{}\"/></Port>\n",
                            networks_[number], length, interface);
  }

  void write_gateway() {
    const std::uint64_t latency =
        longest_crossing_ == 0 ? kAssumedLatency : with_margin(longest_crossing_, 50);
    std::string& xml = out_.xml;
    xml +=
        longest_crossing_ == 0
            ? "  <!-- Nothing was seen to cross it: its Latency is assumed. -->\n"
            : fmt::format("  <!-- Frames took {} at most, + 50 %. -->\n", about(longest_crossing_));
    xml += fmt::format("  <Gateway name=\"{}\">\n", options_.gateway);
    xml += fmt::format(
        "    <Provision latency=\"{0}\" jitter=\"{0}\" period=\"{1}\" omission=\"0\" "
        "packetLoss=\"0\" "
        "maxPayload=\"65535\"/>\n",
        tools::time_words(latency), tools::time_words(provided_period()));
    std::set<std::string> used;
    for (std::uint32_t i = 0; i < networks_.size(); ++i) {
      constexpr std::size_t stem = 11;
      std::string interface = tools::interface_like(names_[i]);
      // Names in a recording that are not valid names of interfaces may become equal.
      for (unsigned number = 2; !used.insert(interface).second; ++number)
        interface = fmt::format("{}-{}", tools::interface_like(names_[i]).substr(0, stem), number);
      note_renamed(names_[i], interface);
      write_port(i, interface);
    }
    xml += "  </Gateway>\n";
  }

  /// Notes that the port has another name than the recording, because Linux has no such names.
  void note_renamed(const std::string& name, const std::string& interface) {
    if (name == interface || options_.made_up.contains(name) || !options_.networks.empty()) return;
    out_.left_out.push_back(fmt::format(
        "{}: no interface of Linux has such a name (up to {} letters, digits and . _ - @ +): the "
        "Port has {} in its place; state the one that it is",
        name, tools::kLongestInterface, interface));
  }

  const Observer& observer_;
  const std::vector<std::string>& names_;
  const DraftOptions& options_;
  std::vector<std::string> networks_;
  std::set<std::string> used_;
  std::vector<Channel> channels_;
  std::set<std::uint64_t> subjects_;
  std::set<std::string> channel_names_;  ///< of channels on Ethernet
  std::set<std::string> publishers_;     ///< their names
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
