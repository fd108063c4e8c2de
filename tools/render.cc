// SPDX-License-Identifier: BSD-2-Clause
// Text about channels: verdicts, deliveries, events and errors.
#include "tools/render.hpp"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

Cell outcome(control::Outcome outcome) {
  switch (outcome) {
    case control::Outcome::fit:
      return {"fit", Style::good};
    case control::Outcome::run_time:
      return {"decided at run time", Style::warning};
    case control::Outcome::unfit:
      break;
  }
  return {"unfit", Style::bad};
}

Cell frames(std::uint64_t count, Style style = Style::plain) {
  return {fmt::format("{}", count), count == 0 ? Style::plain : style};
}

/// The first problem of a channel, and how many more there are.
Cell problems_cell(const control::Channel& channel) {
  if (channel.withdrawn) return {"WITHDRAWN", Style::bad};
  if (channel.problems.empty()) return {};
  const auto more = channel.problems.size() - 1;
  return {channel.problems.front() + (more == 0 ? "" : fmt::format(" (and {} more)", more)),
          Style::bad};
}

std::string provided(const control::Row& row) {
  if (!row.provided_known) return "nothing";
  const auto value = print_value(row.attribute, row.provided, row.unit);
  return row.dynamic ? "at best " + value : value;
}

std::string rows_of(const control::Channel& channel, Color color) {
  TextTable table({{"WHERE"},
                   {"ATTRIBUTE"},
                   {"REQUIRED", Align::right},
                   {"PROVIDED", Align::right},
                   {"OUTCOME"},
                   {"MARGIN"}});
  for (const auto& row : channel.rows)
    table.add({{row.where},
               {row.attribute},
               {print_value(row.attribute, row.required, row.unit)},
               {provided(row)},
               outcome(row.outcome),
               {row.margin}});
  auto text = table.text(color, "  ");
  if (channel.rows_left_out != 0)
    text += fmt::format("  and {}{}\n", many(channel.rows_left_out, "more comparison"),
                        channel.granted ? "" : "; those that do not fit go first");
  return text;
}

/// "refused  emergency-switch (0xa4efeccc3210b497) from second-can to robot-can: why"
std::string verdict_line(const control::Channel& channel, Color color) {
  const auto [text, style] = verdict_cell(channel.granted);
  auto line = styled(text, style, color) + "  " + styled(channel.name, Style::bold, color) +
              fmt::format(" ({})", core::format_subject(channel.subject));
  if (!channel.from.empty()) line += " from " + printable(channel.from);
  if (!channel.to.empty()) line += " to " + printable(channel.to);
  if (!channel.reason.empty()) line += ": " + printable(channel.reason);
  return line + '\n';
}

/// What each medium gives: "awds 600 kB/s free or its own, robot-can response 310 us".
std::string media_of(const control::Channel& channel) {
  std::vector<std::string> parts;
  for (const auto& use : channel.media) {
    if (use.path_rate != 0)
      parts.push_back(
          fmt::format("{} {} free or its own", use.network, bytes_per_second(use.available)));
    if (use.response_ns != 0)
      parts.push_back(fmt::format("{} response {}", use.network, print_duration(use.response_ns)));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// A time in whole microseconds; less is of no use to a person.
std::string about(std::uint64_t ns) { return print_duration(ns - ns % 1'000); }

/// How events arrive: "1001 events, 19.975 a second, jitter 6 ms, 4 missing; the latest 200 ms ago,
/// …".
std::string arrivals_of(const control::Watch& watch) {
  if (watch.events == 0)
    return fmt::format("nothing has come for {}{}", about(watch.since_last_ns),
                       watch.missing_now ? ": MISSING" : "");
  // Publishers share the identifier, so the regularity of one of them is not known.
  if (watch.shared)
    return fmt::format(
        "only whether none of those that the gate cannot distinguish sends; the latest event {} "
        "ago{}",
        about(watch.since_last_ns), watch.missing_now ? ": MISSING" : "");
  std::string text = many(watch.events, "event");
  if (watch.rate_millihertz != 0)
    text += fmt::format(", {} a second", static_cast<double>(watch.rate_millihertz) / 1e3);
  text += fmt::format(", jitter {}, {} missing; the latest {} ago", about(watch.jitter_ns),
                      watch.missing, about(watch.since_last_ns));
  if (watch.missing_now) text += ": MISSING";
  return text;
}

/// The gaps between events: "44 ms to 101 ms, the latest 49 ms; in periods 0.875 to 1: 499, …".
std::string gaps_of(const control::Watch& watch) {
  if (watch.last_gap_ns == 0 || watch.shared) return {};
  std::vector<std::string> bins;
  for (std::size_t i = 0; i < watch.gaps.size(); ++i) {
    if (watch.gaps[i] == 0) continue;
    const bool last = i + 1 == watch.gaps.size();
    const double from = static_cast<double>(i) / 8;
    bins.push_back(last ? fmt::format("{} and more: {}", from, watch.gaps[i])
                        : fmt::format("{} to {}: {}", from, from + 0.125, watch.gaps[i]));
  }
  return fmt::format("{} to {}, the latest {}; in periods {}", about(watch.shortest_gap_ns),
                     about(watch.longest_gap_ns), about(watch.last_gap_ns), fmt::join(bins, ", "));
}

std::string subscribers_of(const control::Channel& channel) {
  auto names = fmt::format("{}", fmt::join(channel.subscribers, ", "));
  if (channel.subscribers_left_out != 0)
    names += fmt::format(" and {} more", channel.subscribers_left_out);
  return names;
}

/// "in all 7 passed, 0 dropped; 2 would have been dropped, audit mode passed them"
std::string frames_of(const control::Channel& channel) {
  if (!channel.carried_by.empty())
    return fmt::format("not counted: {} forwards it, and not this gateway",
                       printable(fmt::format("{}", fmt::join(channel.carried_by, ", "))));
  if (channel.crosses_no_gate) return "not counted: they cross no gate of this gateway";
  auto text = fmt::format("in all {} passed, {} dropped", channel.passed, channel.dropped);
  if (channel.would_drop != 0)
    text += fmt::format("; {} would have been dropped, audit mode passed them", channel.would_drop);
  if (channel.excess != 0) text += fmt::format("; {} were more than admitted", channel.excess);
  if (channel.would_exceed != 0)
    text += fmt::format(" ({} of these passed in audit mode)", channel.would_exceed);
  return text;
}

std::string delivery(const control::Channel& channel, Color color, bool in_full) {
  auto text = verdict_line(channel, color) + rows_of(channel, color);
  const auto also = [&](std::string_view name, const std::string& value) {
    if (!value.empty()) text += fmt::format("  {:<11}  {}\n", printable(name), printable(value));
  };
  if (channel.refused_by)
    also("refused by",
         channel.refused_by->gateway +
             (channel.refused_by->hop.empty() ? std::string() : ", at " + channel.refused_by->hop));
  for (const auto& problem : channel.problems) also("problem", problem);
  also("set", set_in_use(channel));
  also("route", way(channel.route));
  for (const auto& use : channel.media) also(use.network, describe(use));
  also("publisher", channel.publisher);
  also("subscribers", subscribers_of(channel));
  if (channel.admission != 0)
    also("admission",
         fmt::format("{0} (mlccactl release --id {0} takes it back)", channel.admission));
  if (channel.sporadic)
    also("arrival", "sporadic: events come when something happens, and silence means nothing");
  also("reaction", channel.reaction);
  if (in_full) {
    also("importance", fmt::format("{}", channel.importance));
    also("frames", frames_of(channel));
    if (channel.watch) {
      also("watched", arrivals_of(*channel.watch));
      also("gaps", gaps_of(*channel.watch));
    }
  }
  return text;
}

/// The admissions for which the description has no place, so that they carry nothing; empty if
/// there are none.
std::string left_out_text(const control::Channels& channels, Color color) {
  std::string text;
  for (const control::LeftOutAdmission& one : channels.admissions_left_out)
    text += styled("left out", Style::bad, color) +
            fmt::format("  admission {} of {}: {}\n", one.admission, printable(one.channel),
                        printable(one.reason));
  if (!text.empty())
    text +=
        "An admission that is left out carries nothing and reserves nothing. It is decided again "
        "with the next\ndescription, or when the gateway that it waits for agrees, unless "
        "'mlccactl release' ends it.\n";
  return text;
}

}  // namespace

std::string render(const control::Channels& channels, Color color) {
  TextTable table({{"CHANNEL"},
                   {"SUBJECT"},
                   {"FROM"},
                   {"TO"},
                   {"VERDICT"},
                   {"PROBLEMS"},
                   {"CARRIED BY"},
                   {"SET"},
                   {"PASSED", Align::right},
                   {"DROPPED", Align::right},
                   {"WOULD DROP", Align::right},
                   {"ADMISSION", Align::right},
                   {"MEDIA"},
                   {"REASON"}});
  for (const auto& channel : channels.channels)
    table.add({{channel.name},
               {core::format_subject(channel.subject)},
               {channel.from},
               {channel.to},
               verdict_cell(channel.granted),
               problems_cell(channel),
               {fmt::format("{}", fmt::join(channel.carried_by, ", "))},
               {set_in_use(channel)},
               channel.crosses_no_gate ? Cell{"-"} : frames(channel.passed),
               frames(channel.dropped, Style::warning),
               channel.would_drop == 0 ? Cell{} : frames(channel.would_drop, Style::warning),
               {channel.admission == 0 ? "" : fmt::format("{}", channel.admission)},
               {media_of(channel)},
               {channel.reason}});
  const std::string omitted = left_out_text(channels, color);
  return (table.empty() ? "no channel has a publisher and a subscriber\n" : table.text(color)) +
         (omitted.empty() ? "" : '\n' + omitted);
}

std::string explain(const control::Channels& channels, Color color, bool in_full) {
  std::string omitted = left_out_text(channels, color);
  if (channels.channels.empty() && !omitted.empty()) return omitted;
  if (channels.channels.empty())
    return styled("refused", Style::bad, color) +
           "  nothing to deliver: no publisher or no subscriber of the channel is known\n";
  std::string text;
  for (const auto& channel : channels.channels) {
    if (!text.empty()) text += '\n';
    text += delivery(channel, color, in_full);
  }
  if (channels.left_out != 0)
    text += fmt::format("\nand {}{}\n", many(channels.left_out, "more delivery", "more deliveries"),
                        std::ranges::all_of(channels.channels, &control::Channel::granted)
                            ? ", all granted"
                            : "; what is refused is listed first");
  if (!omitted.empty()) text += '\n' + omitted;
  return text;
}

std::string what_stops(const control::Channels& channels, std::string_view name, Color color) {
  std::string text;
  std::size_t granted = 0;
  for (const auto& channel : channels.channels) {
    if (!channel.granted) continue;
    ++granted;
    text += "  " + styled("stops", Style::bad, color) +
            fmt::format("  from {} ({}) to {} ({})\n", printable(channel.from),
                        printable(channel.publisher), printable(channel.to),
                        printable(subscribers_of(channel)));
    if (!channel.reaction.empty())
      text += fmt::format("         reaction to its loss: {}\n", printable(channel.reaction));
  }
  // Refused deliveries are listed first: if a listed one is granted, all that are not listed are,
  // too.
  const std::size_t others = channels.left_out;
  std::string head = "nothing of it is granted now";
  if (granted + others != 0) head = many(granted + others, "delivery stops", "deliveries stop");
  if (granted == 0 && others != 0)
    head = "up to " + head + ", none of which is listed";
  else if (others != 0)
    text += "  and " + many(others, "more that is not listed\n", "more that are not listed\n");
  return fmt::format(
             "{}, once it is withdrawn: {}; everything of it is refused, also what is described, "
             "until it is reinstated\n",
             printable(name), head) +
         text;
}

std::string lease_note(const control::Admit& request, const std::set<std::uint64_t>& admissions) {
  const auto lease = print_duration(request.lease_ns);
  if (request.hold)
    return fmt::format(
        "held until Ctrl-C or the end of a pipe on standard input; {} later it is released\n",
        lease);
  std::string text = fmt::format("released in {} unless it is renewed\n", lease);
  for (const auto id : admissions) text += fmt::format("  mlccactl renew --id {} renews it\n", id);
  return text;
}

std::string render(const control::Done& done, Color color) {
  return styled(done.message.empty() ? "done" : done.message, Style::plain, color) + '\n';
}

std::string render(const control::Event& event, Color color) {
  auto line = print_moment(event.unix_ns) + "  ";
  line += styled(fmt::format("{:<9}", event.kind), style_of_event(event.kind), color) + "  ";
  if (event.subject != 0)
    line += fmt::format("{} ({}) ", printable(event.channel), core::format_subject(event.subject));
  if (!event.network.empty()) line += fmt::format("on {} ", printable(event.network));
  if (event.subject != 0 || !event.network.empty()) line.back() = ':';
  if (line.back() == ':') line += ' ';
  return line + printable(event.message) + '\n';
}

std::string render(const control::Error& error, Color color) {
  auto text = styled("mlccactl: " + error.message, Style::bad, color) + '\n';
  for (const auto& detail : error.details) text += "  " + printable(detail) + '\n';
  return text;
}

}  // namespace mlcca::tools
