// SPDX-License-Identifier: BSD-2-Clause
#include "tools/top/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/many.hpp"

namespace mlcca::tools::top {
namespace {

struct Title {
  std::string_view by_subject;
  std::string_view by_network;
  std::size_t width;
  Align align;
};
/// Titles and least widths in the order of Field. The first two columns get the spare space of a
/// wide screen.
constexpr std::array<Title, kFields> kTitles = {{{"CHANNEL", "NETWORK", 16, Align::left},
                                                 {"ROUTE", "GRANTED", 15, Align::left},
                                                 {"VERDICT", "STATE", 7, Align::left},
                                                 {"RATE/s", "RATE/s", 6, Align::right},
                                                 {"JITTER", "JITTER", 6, Align::right},
                                                 {"LOSS", "LOSS", 5, Align::right},
                                                 {"DROP/s", "DROP/s", 6, Align::right},
                                                 {"RESV", "RESV", 5, Align::right},
                                                 {"USED", "USED", 5, Align::right}}};
/// The title in place of DROP/s in audit mode, which drops nothing.
constexpr std::string_view kWouldDrop = "WOULD";
constexpr std::size_t kNarrow = [] {
  std::size_t sum = kFields - 1;
  for (const Title& title : kTitles) sum += title.width;
  return sum;
}();
// The last column of a terminal stays free, because some terminals then go to the next line.
static_assert(kNarrow < 80);

constexpr std::string_view kKeys =
    "q quit  s sort  r reverse  / filter  n networks/subjects  space pause  h help";
constexpr std::array<std::string_view, 17> kHelp = {
    "q          quit",
    "s          sort by the next column, the second line says which",
    "r          the other way round",
    "/          show only what contains a text: Enter takes it, Esc leaves it",
    "n          by network, by subject",
    "space      stop and go on",
    "up, down   and page up, page down: move through the rows",
    "",
    "RATE/s     frames that passed",
    "JITTER     furthest that a gap between two events was from the period",
    "LOSS       events that did not come",
    "DROP/s     frames that the gate dropped",
    "WOULD      in audit mode: frames a second that it would have dropped, and passed",
    "RESV       reserved, of the resource on the route that it takes the most of",
    "USED       of what is reserved, by the events that passed",
    "-          unknown, or not measured",
    "           any key leaves this help"};

std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; }));
}

/// The first `columns` characters, with "~" at the end if something was cut off.
std::string clipped(std::string_view text, std::size_t columns) {
  if (width(text) <= columns) return std::string(text);
  if (columns == 0) return {};
  std::size_t end = 0;
  for (std::size_t seen = 0; end < text.size(); ++end)
    if ((static_cast<unsigned char>(text[end]) & 0xc0U) != 0x80 && ++seen == columns) break;
  return std::string(text.substr(0, end)) + "~";
}

std::string cell(std::string_view text, std::size_t columns, Align align, Style style,
                 Color color) {
  const auto shown = clipped(printable(text), columns);
  const std::string space(columns - width(shown), ' ');
  const auto colored = styled(shown, style, color);
  return align == Align::right ? space + colored : colored + space;
}

std::array<std::string, kFields> texts_of(const Row& row) {
  return {row.name,
          row.place,
          row.verdict,
          short_number(row.rate),
          short_time(row.jitter),
          short_share(row.loss),
          short_number(row.drops),
          short_share(row.reserved),
          short_share(row.used)};
}

/// Further columns for the state of a network ("unavailable"), which is longer than a verdict; the
/// place ("2 of 2") needs fewer than a route.
constexpr std::size_t kLongerState = 4;

std::array<std::size_t, kFields> widths_of(const std::vector<Row>& rows, bool by_network,
                                           std::size_t columns) {
  std::array<std::size_t, kFields> widths{};
  for (std::size_t i = 0; i < kFields; ++i) widths[i] = kTitles[i].width;
  if (by_network) {
    widths[static_cast<std::size_t>(Field::verdict)] += kLongerState;
    widths[1] -= kLongerState;
  }
  std::size_t spare = columns > kNarrow + 1 ? columns - kNarrow - 1 : 0;
  std::array<std::size_t, 2> wanted{};
  for (const Row& row : rows) {
    wanted[0] = std::max(wanted[0], width(row.name));
    wanted[1] = std::max(wanted[1], width(row.place));
  }
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto more = std::min(spare, wanted[i] - std::min(wanted[i], widths[i]));
    widths[i] += more;
    spare -= more;
  }
  return widths;
}

std::string titles(const View& view, bool audit, const std::array<std::size_t, kFields>& widths,
                   Color color) {
  std::string line;
  for (std::size_t i = 0; i < kFields; ++i) {
    auto title = view.by_network ? kTitles[i].by_network : kTitles[i].by_subject;
    if (audit && static_cast<Field>(i) == Field::drops) title = kWouldDrop;
    if (i != 0) line += ' ';
    line += cell(title, widths[i], kTitles[i].align, Style::bold, color);
  }
  return line;
}

Style style_of(const Row& row, Field field) {
  if (field == Field::verdict) return row.style;
  if (field == Field::drops && row.drops.value_or(0) > 0) return Style::warning;
  if (field == Field::loss && row.loss.value_or(0) > 0) return Style::warning;
  // A tolerance for differences between clocks.
  if (field == Field::used && row.used.value_or(0) > 1.01) return Style::warning;
  return Style::plain;
}

std::string line_of(const Row& row, const std::array<std::size_t, kFields>& widths, Color color) {
  const auto texts = texts_of(row);
  std::string line;
  for (std::size_t i = 0; i < kFields; ++i) {
    if (i != 0) line += ' ';
    line +=
        cell(texts[i], widths[i], kTitles[i].align, style_of(row, static_cast<Field>(i)), color);
  }
  return line;
}

std::string about(const View& view, std::size_t shown, const Heading& heading) {
  auto text = fmt::format("by {}, sorted by {}{}, {}", view.by_network ? "network" : "subject",
                          name_of(view.sort), view.reverse ? " reversed" : "", many(shown, "row"));
  if (!view.filter.empty()) text += fmt::format(", filter '{}'", view.filter);
  if (!heading.interval.empty()) text += ", each " + heading.interval;
  if (view.paused) text += ", PAUSED";
  return text;
}

/// The titles and at most `room` rows, from the first visible one.
std::vector<std::string> table(const std::vector<Row>& rows, const View& view, bool audit,
                               std::size_t columns, std::size_t room, Color color) {
  // Too narrow for complete columns: lines are cut off at the right.
  const bool fits = columns >= kNarrow;
  const Color shown = fits ? color : Color::no;
  const auto widths = widths_of(rows, view.by_network, columns);
  const auto cut = [&](const std::string& line) { return fits ? line : clipped(line, columns); };
  std::vector<std::string> lines = {cut(titles(view, audit, widths, shown))};
  const std::size_t last_page = rows.size() - std::min(rows.size(), std::max<std::size_t>(room, 1));
  const std::size_t first = std::min(view.first, last_page);
  for (std::size_t i = first; i < std::min(rows.size(), first + room); ++i)
    lines.push_back(cut(line_of(rows[i], widths, shown)));
  return lines;
}

}  // namespace

Heading heading_of(const control::Status& status) {
  Heading heading;
  heading.gateway = status.gateway + " of " + status.system;
  heading.state = fmt::format(
      "{}, {}, {} granted, {} refused", status.mode == "enforce" ? status.mode : "AUDIT MODE",
      status.open ? "open" : "CLOSED", status.channels_granted, status.channels_refused);
  heading.audit = status.mode == "audit";
  heading.alarming = status.mode != "enforce" || !status.open;
  const auto& reasons = status.health.reasons;
  heading.problem = reasons.empty() ? status.problem : reasons.front();
  if (const auto more = reasons.size() + status.health.left_out; more > 1)
    heading.problem += fmt::format(" (and {} more)", more - 1);
  return heading;
}

std::string short_number(std::optional<double> value) {
  if (!value) return "-";
  double v = *value;
  constexpr double least = 0.005;  // less would be 0 with two decimals
  if (v > 0 && v < least) return "<.01";
  constexpr std::array<std::string_view, 4> units = {"", "k", "M", "G"};
  std::size_t unit = 0;
  while (v >= 9999.5 && unit + 1 < units.size()) {
    v /= 1000;
    ++unit;
  }
  if (v >= 999.5) return fmt::format("{:.0f}{}", std::min(v, 99999.0), units[unit]);
  int decimals = 2;
  if (v >= 9.995) decimals = 1;
  if (v >= 99.95) decimals = 0;
  auto text = fmt::format("{:.{}f}", v, decimals);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text + std::string(units[unit]);
}

std::string short_time(std::optional<double> seconds) {
  if (!seconds) return "-";
  if (*seconds >= 0.9995) return short_number(seconds) + "s";
  if (*seconds >= 0.0009995) return short_number(*seconds * 1e3) + "ms";
  if (*seconds >= 0.0000009995) return short_number(*seconds * 1e6) + "us";
  return short_number(*seconds * 1e9) + "ns";
}

std::string short_share(std::optional<double> share) {
  if (!share) return "-";
  const double percent = *share * 100;
  if (percent > 0 && percent < 0.05) return "<0.1%";
  if (percent >= 9999.5) return ">999%";
  if (percent >= 99.95) return fmt::format("{:.0f}%", percent);
  const auto text = fmt::format("{:.1f}", percent);
  return (text.ends_with(".0") ? text.substr(0, text.size() - 2) : text) + "%";
}

std::size_t room_for_rows(const Heading& heading, Size size) {
  const std::size_t frame = heading.problem.empty() ? 4 : 5;
  return size.lines - std::min(size.lines, frame);
}

std::vector<std::string> screen(const Heading& heading, const std::vector<Row>& rows,
                                const View& view, Size size, Color color) {
  const std::size_t columns = std::max<std::size_t>(size.columns, 1);
  const bool batch = size.lines == 0;
  const auto whole = [&](std::string_view text, Style style = Style::plain) {
    return styled(clipped(printable(text), columns), style, color);
  };
  std::vector<std::string> lines = {
      whole(fmt::format("{}{}{}: {}", heading.time, heading.time.empty() ? "" : "  ",
                        heading.gateway, heading.state),
            heading.alarming ? Style::bad : Style::bold),
      whole(about(view, rows.size(), heading))};
  if (!heading.problem.empty()) lines.push_back(whole(heading.problem, Style::bad));

  const std::size_t room = batch ? rows.size() : room_for_rows(heading, size);
  if (view.help && !batch) {
    lines.emplace_back();
    for (const auto text : kHelp) lines.push_back(whole(text));
    lines.resize(std::min(lines.size(), size.lines - std::min<std::size_t>(size.lines, 1)));
  } else {
    for (auto& line : table(rows, view, heading.audit, columns, room, color))
      lines.push_back(std::move(line));
  }
  if (batch) return lines;
  lines.resize(std::max(lines.size(), size.lines - std::min<std::size_t>(size.lines, 1)));
  lines.push_back(view.typing ? whole("filter: " + view.typed + "_", Style::bold)
                              : whole(kKeys, Style::dim));
  lines.resize(size.lines);
  return lines;
}

}  // namespace mlcca::tools::top
