// SPDX-License-Identifier: BSD-2-Clause
#include "tools/audit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "tools/render.hpp"
#include "tools/times.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

/// At most so many additions are printed below the table.
constexpr std::size_t kMostAdditions = 8;

std::string advice_lines(const control::Audit& audit) {
  std::set<std::string> advised;
  for (const control::Finding& f : audit.findings)
    if (std::string line = advice(f); !line.empty()) advised.insert(std::move(line));
  if (advised.empty()) return {};
  std::string out = "\nOf deliveries that the description has:\n";
  std::size_t lines = 0;
  for (const std::string& line : advised)
    if (lines++ < kMostAdditions) out += "- " + line + '\n';
  if (lines > kMostAdditions) out += fmt::format("and {} more\n", lines - kMostAdditions);
  return out;
}

/// The direction; empty if it is not known.
const char* direction_of(const control::Finding& f) {
  if (f.others && f.channel.empty()) return "";
  return f.egress ? "out" : "in";
}

bool is_malformed(const control::Finding& f) {
  return reason_of(f) == core::FrameReason::malformed;
}

bool is_part(const control::Finding& f) {
  return f.channel.empty() && reason_of(f) == core::FrameReason::fragment;
}

/// Of frames that no description can admit: what was read of them.
std::string read_of_them(const control::Finding& f) {
  std::string out = f.reason;
  const char* before = ": ";
  if (is_malformed(f) && f.length != 0) {
    out += fmt::format("{}at most {} with headers", before, many(f.length, "byte"));
    before = ", ";
  }
  if (!f.described.empty()) out += fmt::format("{}it names {}", before, f.described);
  return out;
}

/// The reason. If the description has the channel, its delivery or publisher is what it lacks.
std::string stated_reason_of(const control::Finding& f) {
  const auto reason = reason_of(f);
  if (reason && reason != core::FrameReason::unknown && !core::is_of_sender(*reason))
    return read_of_them(f);
  if (f.described.empty()) return f.reason;
  if (!f.publisher.empty())
    return fmt::format("{}: it differs from {} of {}", f.reason, f.described, f.publisher);
  const bool lacks_delivery = f.egress && reason_of(f) == core::FrameReason::unknown;
  return fmt::format("{}: {} has no such {}", f.reason, f.described,
                     lacks_delivery ? "delivery" : "publisher");
}

/// For how long audit mode would have dropped nothing.
std::string clean_words(const control::Audit& audit) {
  constexpr std::uint64_t second = 1'000'000'000;
  if (audit.clean_ns >= second)
    return fmt::format("for {} nothing would have been dropped", core::format_span(audit.clean_ns));
  return "for less than a second nothing would have been dropped: the time begins again with each "
         "such frame, reload, start and change of the mode";
}

/// The lines that admit what was refused; empty if there are none.
std::string addition_lines(const control::Audit& audit) {
  std::string out;
  std::size_t all = 0;
  for (const std::string& one : additions_of(audit))
    if (!one.empty() && ++all <= kMostAdditions) out += '\n' + one;
  if (all == 0) return {};
  if (all > kMostAdditions)
    out += fmt::format("\n{} more: 'mlccactl audit report --xml' prints them all\n",
                       all - kMostAdditions);
  return "\nTo admit what is wanted of it, add to the description:\n" + out;
}

/// What frames are in the rows that name no sender.
std::string notes_on(const control::Audit& audit) {
  std::string out;
  const auto has_others = [&audit](bool of_deliveries) {
    return std::ranges::any_of(audit.findings, [=](const control::Finding& f) {
      return f.others && f.channel.empty() != of_deliveries;
    });
  };
  if (has_others(false))
    out +=
        "others: frames of more kinds than are counted one by one; identifier, subject and sender "
        "are not known\n";
  if (has_others(true))
    out +=
        "others as the sender: more senders of a delivery than are counted one by one, or the "
        "granted "
        "sender where its frames are not admitted\n";
  if (audit.left_out != 0)
    out += many(audit.left_out, "further one had fewer frames: they are in others\n",
                "further ones had fewer frames: they are in others\n");
  if (std::ranges::any_of(audit.findings, is_malformed))
    out +=
        "malformed: no addition admits these frames, because they have not the form that their "
        "network prescribes, for example are too short; tcpdump or candump shows their content\n";
  if (std::ranges::any_of(audit.findings, is_part))
    out +=
        "part of no admitted message: no addition admits these frames alone; what admits the first "
        "part of their message, which has its own row, admits them\n";
  return out;
}

}  // namespace

std::string render(const control::Audit& audit, Color color) {
  const bool audits = audit.mode == "audit";
  std::string out = styled(audits ? "AUDIT MODE: nothing is dropped" : "enforcing",
                           audits ? Style::bad : Style::good, color) +
                    fmt::format("; counted since {}\n", print_second(audit.since_unix_s));
  if (audits) out += clean_words(audit);
  if (audit.when_clean_ns != 0)
    out +=
        fmt::format("; the gates enforce after {} without", core::format_span(audit.when_clean_ns));
  if (audits) out += '\n';
  if (audit.findings.empty())
    return out + "\nnothing was refused when the gates were last read, about a second ago\n";
  TextTable table({{"INTERFACE"},
                   {"DIRECTION"},
                   {"FRAME OR DELIVERY"},
                   {"SENDER"},
                   {"WOULD DROP", Align::right},
                   {"DROPPED", Align::right},
                   {"FIRST"},
                   {"LAST"},
                   {"REASON"}});
  const auto number = [](const control::Finding& f, std::uint64_t n) {
    if (n == 0) return std::string();
    return fmt::format("{}{}", f.at_least ? "at least " : "", n);
  };
  for (const control::Finding& f : audit.findings)
    table.add({{f.interface},
               {direction_of(f)},
               {name_of(f)},
               {sender_of(f)},
               {number(f, f.would_drop)},
               {number(f, f.dropped)},
               {print_second(f.first_unix_s)},
               {print_second(f.last_unix_s)},
               {stated_reason_of(f)}});
  out += '\n' + table.text(color);
  return out + notes_on(audit) + advice_lines(audit) + addition_lines(audit);
}

}  // namespace mlcca::tools
