// SPDX-License-Identifier: BSD-2-Clause
// Drafts the elements for what the gates refused. A subject names one channel of the whole system,
// so findings of several gates about one subject become one channel.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "mlcca/arithmetic.hpp"
#include "tools/audit.hpp"
#include "tools/elements.hpp"
#include "tools/escape.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

using core::Profile;

using core::FrameReason;

/// Whether it is about frames of a described channel that another sender than the granted one has
/// sent.
bool is_of_sender(const control::Finding& f) {
  const auto reason = reason_of(f);
  return f.channel.empty() && !f.others && reason && core::is_of_sender(*reason);
}

/// Whether it is about datagrams, which may have the subject 0.
bool is_datagram(const control::Finding& f) {
  return f.subject != 0 || !f.address.empty() || !f.mac.empty();
}

/// Decodes the identifier of a CAN frame; nullopt if no channel of the profile has it. A packet of
/// a J1939 message has none either, but names its sender.
std::optional<IdentifierParts> channel_of(const control::Finding& f) {
  const auto profile = core::words::kProfiles.find(f.profile);
  if (!profile || !core::names_channels(*profile)) return std::nullopt;
  const std::uint32_t id = f.can_id & (core::kExtendedFlag | core::kExtendedBits);
  const bool is_part = reason_of(f) == FrameReason::fragment;
  return is_control(*profile, id) && !is_part ? std::nullopt : parts_of(*profile, id);
}

/// What the elements for one finding are made from.
struct Elements {
  std::string channel;
  std::string subject;
  std::string binding;    ///< empty: frames carry the subject itself
  std::string publisher;  ///< further XML attributes of the publisher
  std::uint32_t bytes = 0;
  std::string note;
};

std::optional<Elements> elements_of_can(const control::Finding& f) {
  const auto parts = channel_of(f);
  if (!parts) return std::nullopt;
  const Profile profile = *core::words::kProfiles.find(f.profile);
  const core::ProfileTraits& traits = core::traits_of(profile);
  Elements out;
  out.channel = channel_name(profile, f.network, parts->number);
  if (parts->destination) out.channel += fmt::format("-to-{:02X}", *parts->destination);
  out.subject = core::format_subject(subject_of(out.channel));
  std::string format;
  if (f.fd) format = R"( format="fd")";
  if (f.xl) format = R"( format="xl")";
  if ((f.can_id & core::kRemoteFlag) != 0) format += R"( remote-frames="true")";
  const auto priority = traits.has_number_priority ? std::optional(parts->priority) : std::nullopt;
  out.binding = fmt::format("<Binding channel=\"{}\"{}>{}</Binding>", escaped(out.channel), format,
                            binding_element(profile, parts->number, priority, parts->destination));
  if (core::has_nodes(profile)) out.publisher += fmt::format(R"( node="{}")", parts->node);
  if (traits.has_sender_priority)
    out.publisher += fmt::format(R"( priority="{}")", parts->priority);
  const std::uint32_t tail = traits.fragmentation == nullptr ? 0 : traits.fragmentation->tail;
  out.bytes = f.length - std::min(f.length, tail);
  if (parts->is_fragment)
    out.note = " Its events have several frames: learn finds how long they are.";
  return out;
}

/// The network that a publisher of the frames is on; empty if it is a program on this computer.
const std::string& network_of(const control::Finding& f) {
  return f.egress ? f.entered_network : f.network;
}

/// Whether it is about frames of no delivery that their identifier or subject lets admit. Others
/// are malformed, for example.
bool asks_for_channel(const control::Finding& f) {
  return reason_of(f) == FrameReason::unknown || is_of_sender(f);
}

std::optional<Elements> elements_of(const control::Finding& f) {
  if (!asks_for_channel(f)) return std::nullopt;
  if (is_of_sender(f) &&
      (!f.publisher.empty() || (f.egress && f.user.empty() && network_of(f).empty())))
    return std::nullopt;
  if (is_can_frame(f)) return elements_of_can(f);
  if (f.subject == 0 || !f.channel.empty()) return std::nullopt;
  Elements out;
  out.subject = core::format_subject(f.subject);
  out.channel = channel_name(f.network, f.subject);
  out.bytes = f.length;
  const std::string& station = f.address.empty() ? f.mac : f.address;
  // Nobody's address, for example 0.0.0.0.
  if (!network_of(f).empty() && !station.empty() && !core::station_of(station)) return std::nullopt;
  if (!network_of(f).empty() && !station.empty())
    out.publisher = fmt::format(R"( address="{}")", escaped(station));
  return out;
}

/// The daemon reads the counters of the gates so often, in ns. When within that time the frames
/// came is not known.
constexpr std::uint64_t kReading = 1'000'000'000;

/// What is known of when the frames of a finding came.
struct Seen {
  std::uint64_t gap = 0;      ///< ns, in the busiest second
  std::uint64_t frames = 0;   ///< at least
  std::uint64_t seconds = 0;  ///< ns that the readings took in which they were; 0: not known
};

/// Nullopt if only one frame was seen.
std::optional<Seen> seen_of(const control::Finding& f) {
  const std::uint64_t frames = f.dropped + f.would_drop;
  if (f.busy_gap_ns == 0 && frames < 2) return std::nullopt;
  const std::uint64_t seconds =
      f.last_unix_s >= f.first_unix_s ? f.last_unix_s - f.first_unix_s : 0;
  return Seen{
      .gap = f.busy_gap_ns != 0 ? f.busy_gap_ns : std::max<std::uint64_t>(kReading / frames, 1),
      .frames = frames,
      .seconds = f.at_least ? 0 : (seconds + 1) * kReading};
}

/// How much longer than these readings the frames would take if a gate let one pass each Period.
std::uint64_t longer(const Seen& seen, std::uint64_t period) {
  constexpr std::uint64_t clocks = 2000;  // the gates tolerate 500 ppm
  const std::uint64_t all = mul_saturating(seen.frames, period - period / clocks);
  return seen.seconds == 0 || all < seen.seconds ? 0 : all - seen.seconds;
}

/// Whether events with this Period may have looked like those that were seen: in a second there may
/// have been one more than its Periods, and in all the time, too.
bool may_have(const Seen& seen, std::uint64_t period) {
  const std::uint64_t frames = kReading / seen.gap;
  if (frames >= 2 && period > kReading / (frames - 1)) return false;
  return longer(seen, period) <= std::max(kReading, period);
}

/// A round Period that these frames may have, and otherwise one that is not longer than their gap.
std::uint64_t drafted_period(const Seen& seen) {
  const std::uint64_t round = tools::nominal(seen.gap);
  return round <= seen.gap || may_have(seen, round) ? round : seen.gap;
}

/// A channel that is drafted or described, with what all findings say about it.
struct Channel {
  std::string name;
  std::uint64_t period = 0;    ///< of its fastest sender, in ns; 0: no event was seen twice
  std::uint64_t provided = 0;  ///< the longest Period of what carries it, in ns; 0: none is stated
  std::vector<Seen> seen;      ///< of each finding with more than one frame
  std::uint32_t bytes = 1;
  bool is_described = false;
  bool stands = false;          ///< an addition contains it
  std::set<std::string> parts;  ///< elements that additions already contain, without their names
};

/// Drafts the additions, and remembers what the former ones contain.
class Additions {
 public:
  explicit Additions(const control::Audit& audit) : audit_(audit) {
    for (const control::Finding& f : audit.findings)
      if (const auto elements = elements_of(f)) note(f, *elements);
  }

  /// The addition for the next finding; call it in the order of the findings. Empty if nothing is
  /// needed or former additions contain it.
  std::string next(const control::Finding& f) {
    const auto elements = elements_of(f);
    if (!elements) return {};
    Channel& channel = channels_.at(key_of(f, *elements));
    const std::string heading =
        fmt::format("<!-- {} on {}: {}{} -->\n", in_comment(name_of(f)), in_comment(f.interface),
                    seen(f, channel), elements->note);
    std::string body = channel.stands || channel.is_described ? "" : draft(channel, *elements);
    channel.stands = true;
    if (!channel.is_described) body += binding(f, channel, *elements);
    body += publisher(f, channel, *elements) + subscriber(f, channel, *elements);
    return body.empty() ? body : heading + body;
  }

 private:
  static std::string key_of(const control::Finding& f, const Elements& elements) {
    return f.described.empty() ? elements.subject : "described " + f.described;
  }

  void note(const control::Finding& f, const Elements& elements) {
    Channel& channel = channels_[key_of(f, elements)];
    channel.is_described = !f.described.empty();
    if (channel.name.empty())
      channel.name =
          channel.is_described ? f.described : free_name(channel_names_, elements.channel);
    channel.bytes = std::max(channel.bytes, elements.bytes);
    channel.provided = std::max(channel.provided, f.provided_period_ns);
    const auto seen = seen_of(f);
    if (!seen) return;
    const std::uint64_t period = drafted_period(*seen);
    channel.period = channel.period == 0 ? period : std::min(channel.period, period);
    channel.seen.push_back(*seen);
  }

  static std::string seen(const control::Finding& f, const Channel& channel) {
    const std::uint64_t frames = f.dropped + f.would_drop;
    std::string out = fmt::format("{}{} since {}", f.at_least ? "at least " : "",
                                  many(frames, "frame"), print_second(f.first_unix_s));
    const auto seen = seen_of(f);
    if (seen)
      out += fmt::format(", in the busiest second one every {}", time_words(drafted_period(*seen)));
    if (channel.is_described)
      return out + fmt::format(". The description has its channel {}, and lacks {}.{}",
                               in_comment(channel.name),
                               f.egress && !is_of_sender(f) ? "this delivery" : "this publisher",
                               is_of_sender(f) ? warning(f) : "");
    if (channel.stands) return out + fmt::format("; of {}, see above.", in_comment(channel.name));
    return out + stated_period(seen, channel) + not_measured(channel);
  }

  /// What a gate does not keep, and who measures it. A comment contains no two hyphens.
  static std::string not_measured(const Channel& channel) {
    const bool is_early = jitter_of(channel) != 0;
    return fmt::format(
        " When within a second they came was not measured{}, and with arrival=\"sporadic\" silence "
        "is no fault: mlccactl learn, with its option merge, measures it.",
        is_early ? ", so the Jitter lets them come at once" : "");
  }

  /// What Period the draft states, and why.
  static std::string stated_period(const std::optional<Seen>& seen, const Channel& channel) {
    if (channel.period == 0) return "; the Period is assumed.";
    if (channel.period < channel.provided)
      return is_provided(channel)
                 ? fmt::format(": the Period is {}, which network and gateway provide.",
                               time_words(channel.provided))
                 : fmt::format(
                       ": the Period is {}. It is refused, because network and "
                       "gateway provide a Period of {}.",
                       time_words(channel.period), time_words(channel.provided));
    return seen && drafted_period(*seen) == channel.period ? ": the Period is that." : ".";
  }

  /// Whether events with the Period that is provided may have looked like all that were seen.
  static bool is_provided(const Channel& channel) {
    return std::ranges::all_of(channel.seen,
                               [&](const Seen& seen) { return may_have(seen, channel.provided); });
  }

  /// The Period of a drafted channel in ns.
  static std::uint64_t period_of(const Channel& channel) {
    if (channel.period == 0) return std::max(kPeriodOfOne, channel.provided);
    return is_provided(channel) ? std::max(channel.period, channel.provided) : channel.period;
  }

  /// The Jitter with which all frames pass that were seen, in ns and at whatever times they came
  /// between two readings of the counters. By a Period alone two events pass at once. At most the
  /// frames of two readings come at once, the first ones late and the others early.
  static std::uint64_t jitter_of(const Channel& channel) {
    const std::uint64_t period = period_of(channel);
    std::uint64_t jitter = 0;
    for (const Seen& seen : channel.seen) {
      const std::uint64_t of_two =
          mul_div_up(2 * kReading, period, seen.gap) + longer(seen, period);
      const std::uint64_t of_all = seen.seconds == 0 ? of_two : mul_saturating(seen.frames, period);
      const std::uint64_t together = std::min(of_two, of_all);
      jitter = std::max(jitter, together - std::min(together, 2 * period));
    }
    constexpr std::uint64_t step = 1'000'000;
    return (jitter + step - 1) / step * step;
  }

  /// Others may send what only the granted publisher should, and a person may copy the addition.
  static std::string warning(const control::Finding& f) {
    return fmt::format(
        " This is a fault or an attack, unless you know {}: whoever sends can forge identifiers "
        "and addresses.",
        in_comment(sender_of(f)));
  }

  static std::string draft(const Channel& channel, const Elements& elements) {
    return fmt::format(
        "<EventChannel name=\"{}\" arrival=\"sporadic\">\n  <SubjectUID>{}</SubjectUID>\n"
        "  <Attributes period=\"{}\" maxPayload=\"{}\"/>\n</EventChannel>\n",
        escaped(channel.name), elements.subject, time_words(period_of(channel)), channel.bytes);
  }

  static std::string binding(const control::Finding& f, Channel& channel,
                             const Elements& elements) {
    if (elements.binding.empty() || !channel.parts.insert("binding " + f.network).second) return {};
    return fmt::format("<!-- in Network {}: -->\n{}\n", in_comment(f.network), elements.binding);
  }

  std::string publisher(const control::Finding& f, Channel& channel, const Elements& elements) {
    const std::string& network = network_of(f);
    const std::string end =
        (network.empty() ? fmt::format(R"(gateway="{}" user="{}")", escaped(audit_.gateway),
                                       f.user.empty() ? "root" : escaped(f.user))
                         : fmt::format(R"(network="{}")", escaped(network))) +
        elements.publisher;
    if (!channel.parts.insert("publisher " + end).second) return {};
    const char* const unless = channel.is_described ? ", unless it is described" : "";
    const std::uint64_t jitter = channel.is_described ? 0 : jitter_of(channel);
    const std::string attributes =
        jitter == 0
            ? "/>"
            : fmt::format(">\n  <Attributes jitter=\"{}\"/>\n</Publisher>", time_words(jitter));
    return fmt::format("{}<Publisher name=\"{}\" channel=\"{}\" {}{}\n",
                       network.empty() && f.user.empty()
                           ? fmt::format("<!-- sent by this computer: state the user of the "
                                         "program{} -->\n",
                                         unless)
                           : "",
                       escaped(name(elements.channel)), escaped(channel.name), end, attributes);
  }

  /// A subscriber for the frames that were seen; empty for frames that arrive on a described
  /// channel, which has its subscribers, for those of a described delivery, and if an addition
  /// contains it.
  std::string subscriber(const control::Finding& f, Channel& channel, const Elements& elements) {
    if (channel.is_described && (!f.egress || is_of_sender(f))) return {};
    const std::string end = f.egress ? fmt::format(R"(network="{}")", escaped(f.network))
                                     : fmt::format(R"(gateway="{}")", escaped(audit_.gateway));
    if (!channel.parts.insert("subscriber " + end).second) return {};
    return fmt::format("<Subscriber name=\"{}\" channel=\"{}\" {}/>\n",
                       escaped(name(elements.channel + "-receiver")), escaped(channel.name), end);
  }

  /// A name like `wanted` that no other element of the additions has.
  std::string name(const std::string& wanted) { return free_name(names_, wanted); }

  const control::Audit& audit_;
  std::map<std::string, Channel> channels_;
  std::set<std::string> channel_names_;
  std::set<std::string> names_;  ///< of publishers and subscribers
};

/// For a frame of a described publisher that differs from what it states.
std::string advice_on_publisher(const control::Finding& f) {
  const auto profile = core::words::kProfiles.find(f.profile);
  const auto parts = channel_of(f);
  if (!profile || !parts) return {};
  const core::ProfileTraits& traits = core::traits_of(*profile);
  const std::string_view element = traits.element.substr(traits.element.find(' ') + 1);
  std::vector<std::string> wanted;
  for (const std::string& differs : f.differs) {
    if (differs == "priority")
      wanted.push_back(fmt::format("priority=\"{}\" at {}", parts->priority,
                                   traits.has_sender_priority
                                       ? fmt::format("its Publisher {}", f.publisher)
                                       : fmt::format("the {} of its Binding", element)));
    if (differs == "fragment") wanted.emplace_back("a maxPayload that takes several frames");
    if (differs == "remote") wanted.emplace_back("remote-frames=\"true\" at its Binding");
  }
  if (wanted.empty()) return {};
  return fmt::format("if such frames of {} are wanted, state {}", f.described,
                     fmt::join(wanted, ", and "));
}

std::string advice_on_delivery(const control::Finding& f) {
  const auto reason = reason_of(f);
  if (reason == FrameReason::length)
    return fmt::format(
        "if such frames of {} are wanted, state a larger maxPayload: 'mlccactl learn --merge' "
        "measures it",
        f.channel);
  if (reason == FrameReason::excess)
    return fmt::format(
        "if all frames of {} are wanted, state a shorter period, or a jitter: 'mlccactl learn "
        "--merge' measures both",
        f.channel);
  if (reason == FrameReason::source)
    return fmt::format("others send {}, too: 'mlccactl learn --merge' finds who", f.channel);
  if (reason == FrameReason::denied)
    return fmt::format("'mlccactl explain {}' says what would have to change", f.channel);
  return {};
}

/// By which way a frame left: "user 1000", "can1", "kernel"; empty if it is not known.
std::string way_of_sender(const control::Finding& f) {
  return f.user.empty() ? f.entered_by : "user " + f.user;
}

/// The node or station that a frame names; empty if it names none.
std::string station_of(const control::Finding& f) {
  if (!is_can_frame(f)) return print_sender({.address = f.address, .mac = f.mac});
  const auto profile = core::words::kProfiles.find(f.profile);
  const auto parts = channel_of(f);
  if (!parts || !profile || !core::has_nodes(*profile)) return {};
  return fmt::format("node {}", parts->node);
}

}  // namespace

std::optional<FrameReason> reason_of(const control::Finding& f) {
  return core::stated_reason(f.reason).reason;
}

bool is_can_frame(const control::Finding& f) {
  return f.channel.empty() && !is_datagram(f) && !f.others &&
         (asks_for_channel(f) || f.can_id != 0);
}

std::string advice(const control::Finding& f) {
  if (!f.channel.empty()) return advice_on_delivery(f);
  return is_of_sender(f) && !f.publisher.empty() ? advice_on_publisher(f) : std::string();
}

std::string sender_of(const control::Finding& f) {
  if (!f.channel.empty()) return f.others ? "others" : f.sender;
  const std::string station = station_of(f);
  const std::string way = way_of_sender(f);
  if (station.empty() || way.empty()) return station + way;
  return fmt::format("{} by {}", station, way);
}

std::string name_of(const control::Finding& f) {
  if (!f.channel.empty()) return fmt::format("{} of {}", f.channel, f.publisher);
  if (f.others) return "others";
  if (is_datagram(f) && f.subject == 0 && !asks_for_channel(f)) return {};
  if (is_datagram(f)) return core::format_subject(f.subject);
  return is_can_frame(f) ? print_can_id(f.can_id) : std::string();
}

std::vector<std::string> additions_of(const control::Audit& audit) {
  Additions additions(audit);
  std::vector<std::string> out;
  out.reserve(audit.findings.size());
  for (const control::Finding& f : audit.findings) out.push_back(additions.next(f));
  return out;
}

std::string additions(const control::Audit& audit) {
  std::string out;
  for (const std::string& one : additions_of(audit))
    if (!one.empty()) out += (out.empty() ? "" : "\n") + one;
  for (const control::Finding& f : audit.findings)
    if (f.others)
      out += fmt::format(
          "{}<!-- {} on {} ({}) since {} of further {}: what they need is not known. -->\n",
          out.empty() ? "" : "\n", many(f.dropped + f.would_drop, "frame"), in_comment(f.interface),
          in_comment(f.reason), print_second(f.first_unix_s),
          f.channel.empty() ? "kinds" : "senders of " + in_comment(f.channel));
  return out;
}

}  // namespace mlcca::tools
