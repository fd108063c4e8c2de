// SPDX-License-Identifier: BSD-2-Clause
#include "tools/audit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "core/model/text.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"
#include "tools/escape.hpp"
#include "tools/render.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

using core::Profile;

/// So many additions stand below the table.
constexpr std::size_t kMostAdditions = 8;

bool is_can_frame(const control::Finding& f) {
  return f.channel.empty() && f.subject == 0 && f.reason == "unknown subject";
}

/// What the identifier of a CAN frame says of its channel; nothing where it has none.
std::optional<IdentifierParts> channel_of(const control::Finding& f) {
  const auto profile = core::words::kProfiles.find(f.profile);
  if (!profile || *profile == Profile::none) return std::nullopt;
  const std::uint32_t id = f.can_id & (core::kExtendedFlag | core::kExtendedBits);
  return is_control(*profile, id) ? std::nullopt : parts_of(*profile, id);
}

std::string sender_of(const control::Finding& f) {
  if (!is_can_frame(f)) return print_sender({.address = f.address, .mac = f.mac});
  const auto profile = core::words::kProfiles.find(f.profile);
  const auto parts = channel_of(f);
  if (!parts || !profile || !core::has_nodes(*profile)) return {};
  return fmt::format("node {}", parts->node);
}

/// What an addition is made of.
struct Elements {
  std::string channel;
  std::string subject;
  std::string binding;    ///< empty: frames carry the subject
  std::string publisher;  ///< further attributes of it
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
  out.subject = core::format_subject(subject_of(out.channel));
  std::string format;
  if (f.fd) format = R"( format="fd")";
  if (f.xl) format = R"( format="xl")";
  if ((f.can_id & core::kRemoteFlag) != 0) format += R"( remote-frames="true")";
  const auto priority = traits.has_number_priority ? std::optional(parts->priority) : std::nullopt;
  out.binding = fmt::format("<Binding channel=\"{}\"{}>{}</Binding>", escaped(out.channel), format,
                            binding_element(profile, parts->number, priority));
  if (core::has_nodes(profile)) out.publisher += fmt::format(R"( node="{}")", parts->node);
  if (traits.has_sender_priority)
    out.publisher += fmt::format(R"( priority="{}")", parts->priority);
  const std::uint32_t tail = traits.fragmentation == nullptr ? 0 : traits.fragmentation->tail;
  out.bytes = f.length - std::min(f.length, tail);
  if (parts->is_fragment)
    out.note = " Its events have several frames: learn finds how long they are.";
  return out;
}

std::optional<Elements> elements_of(const control::Finding& f) {
  if (is_can_frame(f)) return elements_of_can(f);
  if (f.subject == 0 || !f.channel.empty()) return std::nullopt;
  Elements out;
  out.subject = core::format_subject(f.subject);
  out.channel = fmt::format("{}-{}", f.network, out.subject.substr(2));
  out.bytes = f.length;
  if (!f.egress && !f.address.empty())
    out.publisher = fmt::format(R"( address="{}")", escaped(f.address));
  return out;
}

std::string times_of(const control::Finding& f) {
  const std::uint64_t frames = f.dropped + f.would_drop;
  const std::string since = fmt::format("{} frame{} since {}", frames, frames == 1 ? "" : "s",
                                        print_second(f.first_unix_s));
  if (f.busy_gap_ns == 0) return since + "; the Period is assumed.";
  return fmt::format("{}, in the busiest second one every {}: the Period is that.", since,
                     time_words(nominal(f.busy_gap_ns)));
}

}  // namespace

std::string name_of(const control::Finding& f) {
  if (!f.channel.empty()) return fmt::format("{} of {}", f.channel, f.publisher);
  if (f.subject != 0) return core::format_subject(f.subject);
  return is_can_frame(f) ? print_can_id(f.can_id) : std::string();
}

std::string addition(const control::Audit& audit, const control::Finding& f) {
  const auto elements = elements_of(f);
  if (!elements) return {};
  const std::string channel = escaped(elements->channel);
  const std::string network = escaped(f.network);
  const std::string gateway = escaped(audit.gateway);
  const std::uint64_t period = f.busy_gap_ns == 0 ? kPeriodOfOne : nominal(f.busy_gap_ns);
  std::string out = fmt::format(
      "<!-- {} on {}: {}{} -->\n<EventChannel name=\"{}\">\n  <SubjectUID>{}</SubjectUID>\n"
      "  <Attributes period=\"{}\" maxPayload=\"{}\"/>\n</EventChannel>\n",
      in_comment(name_of(f)), in_comment(f.interface), times_of(f), elements->note, channel,
      elements->subject, time_words(period), std::max(elements->bytes, 1U));
  if (!elements->binding.empty())
    out += fmt::format("<!-- in Network {}: -->\n{}\n", in_comment(f.network), elements->binding);
  const std::string end = f.egress ? fmt::format(R"(gateway="{}" user="root")", gateway)
                                   : fmt::format(R"(network="{}")", network);
  if (f.egress) out += "<!-- sent by this computer: state the user of the program -->\n";
  out += fmt::format("<Publisher name=\"{0}\" channel=\"{0}\" {1}{2}/>\n", channel, end,
                     elements->publisher);
  const std::string to =
      f.egress ? fmt::format("network=\"{}\"", network) : fmt::format("gateway=\"{}\"", gateway);
  return out +
         fmt::format("<Subscriber name=\"{0}-receiver\" channel=\"{0}\" {1}/>\n", channel, to);
}

std::string additions(const control::Audit& audit) {
  std::string out;
  for (const control::Finding& f : audit.findings) {
    const std::string one = addition(audit, f);
    if (!one.empty()) out += (out.empty() ? "" : "\n") + one;
  }
  return out;
}

std::string render(const control::Audit& audit, Color color) {
  const bool audits = audit.mode == "audit";
  std::string out = styled(audits ? "AUDIT MODE: nothing is dropped" : "enforcing",
                           audits ? Style::bad : Style::good, color) +
                    fmt::format("; counted since {}\n", print_second(audit.since_unix_s));
  const std::string clean = core::format_span(audit.clean_ns);
  if (audits) out += fmt::format("for {} nothing would have been dropped", clean);
  if (audit.when_clean_ns != 0)
    out +=
        fmt::format("; the gates enforce after {} without", core::format_span(audit.when_clean_ns));
  if (audits) out += '\n';
  if (audit.findings.empty()) return out + "\nnothing was refused\n";
  Table table({{"INTERFACE"},
               {"WAY"},
               {"FRAME OR DELIVERY"},
               {"SENDER"},
               {"WOULD DROP", Align::right},
               {"DROPPED", Align::right},
               {"FIRST"},
               {"LATEST"},
               {"WHY"}});
  const auto number = [](std::uint64_t n) { return n == 0 ? "" : fmt::format("{}", n); };
  for (const control::Finding& f : audit.findings)
    table.add({{f.interface},
               {f.egress ? "out" : "in"},
               {name_of(f)},
               {sender_of(f)},
               {number(f.would_drop)},
               {number(f.dropped)},
               {print_second(f.first_unix_s)},
               {print_second(f.last_unix_s)},
               {f.reason}});
  out += '\n' + table.text(color);
  if (audit.left_out != 0)
    out += fmt::format("{} further ones had fewer frames and are not listed\n", audit.left_out);
  std::vector<std::string> shown;
  std::size_t all = 0;
  for (const control::Finding& f : audit.findings) {
    std::string one = addition(audit, f);
    if (one.empty()) continue;
    if (++all <= kMostAdditions) shown.push_back(std::move(one));
  }
  if (shown.empty()) return out;
  out += "\nTo admit what is wanted of it, add to the description:\n";
  for (const std::string& one : shown) out += '\n' + one;
  if (all > shown.size())
    out += fmt::format("\n{} more: 'mlccactl audit report --xml' prints them all\n",
                       all - shown.size());
  return out;
}

}  // namespace mlcca::tools
