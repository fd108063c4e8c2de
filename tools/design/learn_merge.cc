// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_merge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "base/many.hpp"
#include "core/gates/plan.hpp"
#include "core/model/station.hpp"
#include "core/model/text.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "tools/design/learn_patch.hpp"
#include "tools/elements.hpp"

namespace mlcca::tools::design {
namespace {

/// If at most one of so many events is shorter than the others, the length does not normally vary.
constexpr std::uint64_t kFewOf = 100;
/// Nor does it if a single one of so many is.
constexpr std::uint64_t kOneOfFew = 20;

bool is_seldom_shorter(const learn::DraftPublisher& seen) {
  return (seen.shorter_events == 1 && seen.events >= kOneOfFew) ||
         (seen.shorter_events != 0 && seen.shorter_events <= seen.events / kFewOf);
}

std::optional<std::size_t> network_named(const core::System& system, const std::string& name) {
  const auto found = std::ranges::find(system.networks, name, &core::Network::name);
  if (found == system.networks.end()) return std::nullopt;
  return static_cast<std::size_t>(found - system.networks.begin());
}

/// The binding of frames with this number; nullopt if there is none.
const core::Binding* binding_of(const core::Network& network, std::uint32_t number) {
  const std::uint32_t id = number & learn::kIdentifierBits;
  const bool raw = core::traits_of(network.profile).form == core::IdentifierForm::stated;
  const auto found = std::ranges::find_if(network.bindings, [&](const core::Binding& b) {
    if (!raw) return b.id == id && !b.waits_for_tag();
    return b.extended == ((number & learn::kExtended) != 0) && (id & b.mask) == (b.id & b.mask);
  });
  return found == network.bindings.end() ? nullptr : &*found;
}

void replace_all(std::string& text, const std::string& before, const std::string& after) {
  for (std::size_t at = 0; (at = text.find(before, at)) != std::string::npos; at += after.size())
    text.replace(at, before.size(), after);
}

/// The drafted channel with another name and possibly another subject.
learn::DraftChannel called(learn::DraftChannel row, const std::string& name,
                           std::uint64_t subject) {
  const auto channel = [](const std::string& of) { return "channel=\"" + of + "\""; };
  replace_all(row.channel_xml, "<EventChannel name=\"" + row.name + "\"",
              "<EventChannel name=\"" + name + "\"");
  replace_all(row.channel_xml, fmt::format("<SubjectUID>0x{:016x}<", row.drafted_subject),
              fmt::format("<SubjectUID>0x{:016x}<", subject));
  for (auto& [interface, text] : row.binding_xml)
    replace_all(text, channel(row.name), channel(name));
  for (learn::DraftPublisher& publisher : row.publishers)
    replace_all(publisher.xml, channel(row.name), channel(name));
  replace_all(row.subscriber_xml, channel(row.name), channel(name));
  row.name = name;
  row.drafted_subject = subject;
  return row;
}

/// Whether a gate that holds the stated Period and Jitter drops events of what was seen. The Period
/// drafted of few events does not show that, and is not compared.
bool is_dropped(const learn::DraftPublisher& seen, const AttributeSet& stated) {
  if (!stated.has(Attribute::period) || seen.assumed) return false;
  const core::Policing gate = core::policing_of(stated, 1, 0);
  if (!seen.few.empty()) return learn::Flow::early_of(seen.few, gate.per_frame) > gate.tolerance;
  // With a longer Period events are earlier.
  for (const learn::Rate& rate : seen.rates) {
    if (rate.period >= gate.per_frame && rate.early <= gate.tolerance) return false;
    if (rate.period <= gate.per_frame && rate.early > gate.tolerance) return true;
  }
  // Within the tolerance of clocks and of the draft.
  return seen.period + seen.period / 50 < stated[Attribute::period];
}

/// Whether missing events of a channel are noticed.
bool is_watched(const core::EventChannel& channel) {
  return channel.arrival == core::Arrival::periodic;
}

class Merge {
 public:
  Merge(const core::System& system, const learn::DraftOptions& options)
      : system_(system), options_(options), patch_(system) {
    for (const core::EventChannel& channel : system.channels) {
      names_.insert(channel.name);
      subjects_.insert(channel.subject);
    }
    for (const core::Publisher& publisher : system.publishers) publishers_.insert(publisher.name);
  }

  Result<Merged> run(const learn::Draft& draft) {
    for (const learn::DraftChannel& row : draft.channels) {
      if (!network_of(row.interface)) return fail(not_described(row.interface));
      const auto known = channel_of(row);
      if (const auto done = known ? compare(row, *known) : add(distinct(row)); !done)
        return std::unexpected(done.error());
    }
    compare_transports(draft);
    note_unseen(draft);
    propose_provisions();
    if (!channels_.empty() || !ends_.empty()) patch_.insert_in_system(channels_ + ends_);
    for (const auto& [network, text] : bindings_) patch_.insert_in_network(network, text);
    auto files = patch_.files();
    if (!files) return std::unexpected(files.error());
    merged_.files = std::move(*files);
    merged_.notes = patch_.notes();
    return std::move(merged_);
  }

 private:
  using Of = LearnPatch::Element;
  [[nodiscard]] std::optional<std::size_t> network_of(const std::string& interface) const {
    const auto known = options_.networks.find(interface);
    return known == options_.networks.end() ? std::nullopt : network_named(system_, known->second);
  }
  /// The binding of the identifier that the drafted channel has on a CAN interface; nullptr: there
  /// is none.
  [[nodiscard]] const core::Binding* bound(const learn::DraftChannel& row,
                                           const std::string& interface) const {
    const auto network = network_of(interface);
    return network ? binding_of(system_.networks[*network],
                                static_cast<std::uint32_t>(row.numbers.at(interface)))
                   : nullptr;
  }

  /// The described channel: the one bound to the identifier on the first interface, or else the one
  /// with the same subject.
  [[nodiscard]] std::optional<std::size_t> channel_of(const learn::DraftChannel& row) const {
    if (row.binding_xml.contains(row.interface))
      if (const auto* binding = bound(row, row.interface)) return binding->channel;
    if (row.subject) {
      const auto same =
          std::ranges::find(system_.channels, *row.subject, &core::EventChannel::subject);
      if (same != system_.channels.end())
        return static_cast<std::size_t>(same - system_.channels.begin());
    }
    for (const auto& [interface, text] : row.binding_xml)
      if (const auto* binding = bound(row, interface)) return binding->channel;
    return unbound(row);
  }

  /// The described channel with the same name or subject to which no identifier is bound on these
  /// networks.
  [[nodiscard]] std::optional<std::size_t> unbound(const learn::DraftChannel& row) const {
    for (std::size_t c = 0; !row.subject && c < system_.channels.size(); ++c) {
      const core::EventChannel& channel = system_.channels[c];
      if (channel.name != row.name && channel.subject != row.drafted_subject) continue;
      if (std::ranges::none_of(row.binding_xml, [&](const auto& one) {
            const auto network = network_of(one.first);
            return network && is_bound(*network, c);
          }))
        return c;
    }
    return std::nullopt;
  }
  [[nodiscard]] bool is_bound(std::size_t network, std::size_t channel) const {
    const auto& bindings = system_.networks[network].bindings;
    return std::ranges::find(bindings, channel, &core::Binding::channel) != bindings.end();
  }

  /// A new channel with a name and subject that no other channel has.
  [[nodiscard]] learn::DraftChannel distinct(const learn::DraftChannel& row) {
    const std::string name = free_name(names_, row.name);
    std::uint64_t subject = row.drafted_subject;
    for (std::string text = name; !row.subject && !subjects_.insert(subject).second; text += '+')
      subject = tools::subject_of(text);
    return name == row.name && subject == row.drafted_subject ? row : called(row, name, subject);
  }
  /// The publisher with a name that no other publisher has.
  [[nodiscard]] std::string distinct(const learn::DraftPublisher& publisher) {
    std::string text = publisher.xml;
    replace_all(text, "<Publisher name=\"" + publisher.name + "\"",
                "<Publisher name=\"" + free_name(publishers_, publisher.name) + "\"");
    return text;
  }

  Result<void> add(const learn::DraftChannel& row) {
    for (const auto& [interface, number] : row.numbers)
      if (!network_of(interface)) return fail(not_described(interface));
    channels_ += row.channel_xml;
    for (const learn::DraftPublisher& publisher : row.publishers)
      shortest_ = std::min(shortest_, publisher.period);
    for (const auto& [interface, text] : row.binding_xml) bindings_[*network_of(interface)] += text;
    for (const learn::DraftPublisher& publisher : row.publishers) ends_ += distinct(publisher);
    ends_ += row.subscriber_xml;
    return {};
  }

  /// Replaces the name of the drafted channel in `text` by that of the described one.
  static std::string renamed(const learn::DraftChannel& row, const core::EventChannel& channel,
                             std::string text) {
    replace_all(text, "channel=\"" + row.name + "\"", "channel=\"" + channel.name + "\"");
    return text;
  }

  /// Lists differences from the description. Publishers that are not described are proposed.
  Result<void> compare(const learn::DraftChannel& row, std::size_t number) {
    const core::EventChannel& channel = system_.channels[number];
    if (row.subject && *row.subject != channel.subject)
      merged_.differs.push_back(fmt::format("{}: its events have the subject {} on Ethernet",
                                            channel.name, core::format_subject(*row.subject)));
    compare_bindings(row, number);
    patch_.seen(number, row.seen);
    for (const learn::DraftPublisher& publisher : row.publishers) {
      const auto network = network_of(publisher.interface);
      if (!network) return fail(not_described(publisher.interface));
      seen_.emplace(number, *network);
      const std::string who =
          fmt::format("{} ({} on {})", channel.name, row.identifier, publisher.interface);
      if (const auto* known = described(publisher, number, *network)) {
        compare(publisher, who, *known);
        continue;
      }
      merged_.differs.push_back(who + undescribed(publisher, *network));
      ends_ += renamed(row, channel, distinct(publisher));
    }
    if (std::ranges::find(system_.subscribers, number, &core::Subscriber::channel) ==
        system_.subscribers.end())
      ends_ += renamed(row, channel, row.subscriber_xml);
    return {};
  }

  /// Compares the identifiers of the channel on buses, and proposes bindings where it has none.
  void compare_bindings(const learn::DraftChannel& row, std::size_t number) {
    const core::EventChannel& channel = system_.channels[number];
    for (const auto& [interface, text] : row.binding_xml) {
      const auto network = network_of(interface);
      const auto* binding = bound(row, interface);
      if (!network || (binding != nullptr && binding->channel == number)) continue;
      if (binding == nullptr && is_bound(*network, number)) {
        merged_.differs.push_back(
            fmt::format("{}: is on {} by another identifier than it is bound to there",
                        channel.name, interface));
        continue;
      }
      merged_.differs.push_back(
          binding == nullptr
              ? fmt::format("{}: is on {}, and not bound there", channel.name, interface)
              : fmt::format("{}: is on {}, by an identifier that is bound to {}", channel.name,
                            interface, system_.channels[binding->channel].name));
      if (binding == nullptr) bindings_[*network] += renamed(row, channel, text);
    }
  }

  /// Whether publishers at `place` send what was seen: from a program on the gateway (`local`) or
  /// on the network.
  [[nodiscard]] bool is_sent_at(core::Place place, bool local, std::size_t network) const {
    if (local)
      return place.kind == core::Place::Kind::gateway &&
             system_.gateways[place.index].name == options_.gateway;
    return place.kind == core::Place::Kind::network && place.index == network;
  }

  /// The described publisher of these events; nullptr if there is none.
  [[nodiscard]] const core::Publisher* described(const learn::DraftPublisher& seen,
                                                 std::size_t channel, std::size_t network) const {
    const core::Network& on = system_.networks[network];
    const core::Publisher* wildcard = nullptr;
    for (const core::Publisher& p : system_.publishers) {
      if (p.channel != channel) continue;
      const bool there = is_sent_at(p.place, seen.local, network);
      if (!there) continue;
      if (on.carries_subjects()) {
        if (seen.local || p.station.bits == seen.node) return &p;
        if (p.station.is_wildcard()) wildcard = &p;
      } else if (!core::has_nodes(on.profile) || (p.node && *p.node == seen.node)) {
        return &p;
      }
    }
    return wildcard;
  }

  [[nodiscard]] std::string undescribed(const learn::DraftPublisher& seen,
                                        std::size_t network) const {
    const core::Network& on = system_.networks[network];
    if (seen.local)
      return ": a program on the gateway sends it, and is not described as a publisher";
    if (on.carries_subjects())
      return fmt::format(": {} sends it, and is not described as a publisher there",
                         core::to_text(core::Station{seen.node}));
    if (core::has_nodes(on.profile))
      return fmt::format(": node {} sends it, and is not described as a publisher there",
                         seen.node);
    return ": is sent there, and no publisher is described there";
  }

  void compare(const learn::DraftPublisher& seen, const std::string& who,
               const core::Publisher& p) {
    const AttributeSet& stated = p.attributes;
    const Value period = stated[Attribute::period];
    if (is_dropped(seen, stated) && seen.few.empty() && seen.period >= period)
      merged_.differs.push_back(
          fmt::format("{}: publisher {} states Period {} and Jitter {}, and of the latter {} were "
                      "seen: frames would be dropped",
                      who, p.name, core::format_value(Attribute::period, period),
                      core::format_value(Attribute::jitter, stated[Attribute::jitter]),
                      time_words(seen.jitter)));
    else if (is_dropped(seen, stated))
      merged_.differs.push_back(fmt::format(
          "{}: publisher {} states Period {}, and {} seen: frames would be dropped", who, p.name,
          core::format_value(Attribute::period, period),
          seen.few.empty() ? time_words(seen.period) + " was"
                           : fmt::format("{} events, {} apart at least, were", seen.events,
                                         learn::about(seen.shortest_gap))));
    if (stated.has(Attribute::max_payload) && seen.bytes > stated[Attribute::max_payload])
      merged_.differs.push_back(fmt::format(
          "{}: publisher {} states MaxPayload {}, and {} bytes were seen: frames would be "
          "dropped",
          who, p.name, core::format_value(Attribute::max_payload, stated[Attribute::max_payload]),
          seen.bytes));
    propose(seen, p);
    if (is_seldom_shorter(seen))
      merged_.differs.push_back(fmt::format(
          "{}: publisher {}: {} of {} events {} fewer bytes than the others ({} at least, not {}): "
          "no gate drops a frame for that",
          who, p.name, seen.shorter_events, seen.events, seen.shorter_events == 1 ? "has" : "have",
          seen.least_bytes, seen.bytes));
    if (seen.periodic && is_watched(system_.channels[p.channel]) && stated.has(Attribute::period) &&
        period + period / 2 < seen.period)
      merged_.differs.push_back(fmt::format(
          "{}: publisher {} states Period {}, and {} was seen: it is reported as missing", who,
          p.name, core::format_value(Attribute::period, period), time_words(seen.period)));
  }

  [[nodiscard]] std::size_t index_of(const core::Publisher& p) const {
    return static_cast<std::size_t>(&p - system_.publishers.data());
  }

  /// What its attributes must be, so that what was seen passes and nothing of it is missing.
  void propose(const learn::DraftPublisher& seen, const core::Publisher& p) {
    const AttributeSet& stated = p.attributes;
    const core::EventChannel& channel = system_.channels[p.channel];
    const Value period = stated[Attribute::period];
    const bool shorter = is_dropped(seen, stated);
    const bool longer = seen.periodic && is_watched(channel) && period + period / 2 < seen.period;
    const bool alone =
        std::ranges::count(system_.publishers, p.channel, &core::Publisher::channel) == 1;
    // A longer Period of one publisher is one that the channel's subscribers must accept.
    if (stated.has(Attribute::period) && (shorter || (longer && alone))) {
      const bool own = !alone || period != channel.attributes[Attribute::period];
      const Value fresh = seen.few.empty() ? seen.period : std::min(seen.period, period);
      if (fresh != period)
        patch_.state({own ? Of::publisher : Of::channel, own ? index_of(p) : p.channel, "period"},
                     fresh);
      if (seen.jitter > stated[Attribute::jitter])
        patch_.state({Of::publisher, index_of(p), "jitter"}, seen.jitter);
      shortest_ = std::min(shortest_, fresh);
    }
    propose_length(seen, p);
  }

  void propose_length(const learn::DraftPublisher& seen, const core::Publisher& p) {
    const AttributeSet& stated = p.attributes;
    const core::EventChannel& channel = system_.channels[p.channel];
    if (!stated.has(Attribute::max_payload) || seen.bytes <= stated[Attribute::max_payload]) return;
    if (seen.bytes > channel.attributes[Attribute::max_payload])
      patch_.state({Of::channel, p.channel, "maxPayload"}, seen.bytes);
    if (stated[Attribute::max_payload] != channel.attributes[Attribute::max_payload])
      patch_.state({Of::publisher, index_of(p), "maxPayload"}, seen.bytes);
  }

  /// What is provided must be as short as what is added and changed.
  void propose_provisions() {
    const auto provide = [&](const AttributeSet& provision, Of element, std::size_t index) {
      if (provision.has(Attribute::period) && provision[Attribute::period] > shortest_)
        patch_.state({element, index, "period"}, shortest_);
    };
    for (std::size_t g = 0; g < system_.gateways.size(); ++g)
      if (system_.gateways[g].name == options_.gateway)
        provide(system_.gateways[g].provision, Of::gateway, g);
    for (const auto& [interface, name] : options_.networks)
      if (const auto network = network_named(system_, name))
        provide(system_.networks[*network].provision, Of::network, *network);
  }

  /// Lists networks of Ethernet where events come by another transport than described.
  void compare_transports(const learn::Draft& draft) {
    for (const auto& [interface, transports] : draft.transports) {
      const auto network = network_of(interface);
      if (!network || !system_.networks[*network].carries_subjects()) continue;
      const core::Network& on = system_.networks[*network];
      const std::uint64_t missed = transports.missed_by(on.kind);
      const bool is_broadcast = on.kind == core::NetworkKind::udp_broadcast;
      if (missed != 0)
        merged_.differs.push_back(fmt::format(
            "{}: subscribers of its Kind {} receive events of {}, and {} of {} with events on {} "
            "are of {}: nobody receives them there",
            on.name, core::words::kNetworkKinds.of(on.kind), learn::transport_word(is_broadcast),
            missed, many(transports.all(), "datagram"), interface,
            learn::transport_word(!is_broadcast)));
    }
  }

  void note_unseen(const learn::Draft& draft) {
    std::set<std::size_t> listened;
    for (const learn::DraftChannel& row : draft.channels)
      for (const learn::DraftPublisher& publisher : row.publishers)
        if (const auto network = network_of(publisher.interface)) listened.insert(*network);
    for (const core::Publisher& p : system_.publishers)
      if (p.place.kind == core::Place::Kind::network && listened.contains(p.place.index) &&
          !seen_.contains({p.channel, p.place.index}))
        merged_.differs.push_back(fmt::format(
            "{} of {} on {}: is described, and nothing of it was seen",
            system_.channels[p.channel].name, p.name, system_.networks[p.place.index].name));
  }

  const core::System& system_;
  const learn::DraftOptions& options_;
  std::set<std::string> names_;  ///< of described and proposed channels
  std::set<std::uint64_t> subjects_;
  std::set<std::string> publishers_;     ///< names of publishers
  std::uint64_t shortest_ = UINT64_MAX;  ///< Period that is added or changed, ns
  std::string channels_;
  std::string ends_;
  std::map<std::size_t, std::string> bindings_;         ///< by index of the network
  std::set<std::pair<std::size_t, std::size_t>> seen_;  ///< indices of channel and network
  LearnPatch patch_;
  Merged merged_;
};

}  // namespace

std::string not_described(const std::string& interface) {
  return fmt::format(
      "no port of the gateway names the interface {}: describe its network and port first, or "
      "draft a description of its own by --output",
      interface);
}

Result<void> adopt(const core::System& system, const std::string& gateway,
                   learn::DraftOptions& options) {
  const core::Gateway* here = nullptr;
  for (const core::Gateway& g : system.gateways)
    if (g.name == gateway || (gateway.empty() && system.gateways.size() == 1)) here = &g;
  if (here == nullptr) {
    std::vector<std::string> names;
    names.reserve(system.gateways.size());
    for (const core::Gateway& g : system.gateways) names.push_back(g.name);
    return fail(fmt::format("say by --gateway which one this is: {}", fmt::join(names, ", ")));
  }
  options.gateway = here->name;
  for (const core::Port& port : here->ports)
    if (!port.identity.name.empty())
      options.networks[port.identity.name] = system.networks[port.network].name;
  return {};
}

Result<Merged> merge(const core::System& system, const learn::Draft& draft,
                     const learn::DraftOptions& options) {
  return Merge(system, options).run(draft);
}

}  // namespace mlcca::tools::design
