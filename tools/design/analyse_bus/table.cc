// SPDX-License-Identifier: BSD-2-Clause
// Reads messages from a table of comma-separated values.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/many.hpp"
#include "base/number.hpp"
#include "base/result.hpp"
#include "core/can/analysis.hpp"
#include "tools/design/analyse_bus/bus.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

enum class Field : std::uint8_t {
  name,
  id,
  extended,
  bytes,
  period,
  deadline,
  jitter,
  fd,
  frames,
  node,
};
constexpr std::array<std::string_view, 10> kColumns = {
    "name",        "id",        "extended", "bytes",  "period_us",
    "deadline_us", "jitter_us", "fd",       "frames", "node"};
constexpr std::size_t kRequired = 5;  // the first ones in kColumns
constexpr std::size_t kMissing = ~std::size_t{0};
constexpr std::string_view kHeader =
    "name,id,extended,bytes,period_us, and deadline_us, jitter_us, fd, frames and node if wanted";
constexpr std::string_view kSeparators = ",;\t|";
constexpr std::size_t kMostOfAKind = 20;  // problems that are listed one by one

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return small;
}

/// "a, b and c"
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

/// The line without a comment, which begins with a # outside of quotes.
std::string_view without_comment(std::string_view line) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == '#' && !quoted) return line.substr(0, i);
  }
  return line;
}

/// The separator that occurs most often in the header; a comma if none does.
char separator_of(std::string_view header) {
  return *std::ranges::max_element(kSeparators, {},
                                   [&](char c) { return std::ranges::count(header, c); });
}

/// Removes the first cell from the line; nullopt if its quotes are wrong. Within quotes a separator
/// is content, and two quotes stand for one. `more`: another cell follows.
std::optional<std::string> take_cell(std::string_view& line, char separator, bool& more) {
  std::string cell;
  const auto begin = line.find_first_not_of(separator == '\t' ? " " : " \t");
  const bool quoted = begin != std::string_view::npos && line[begin] == '"';
  std::size_t at = quoted ? begin + 1 : 0;
  if (quoted) {
    while (at < line.size() && (line[at] != '"' || line.substr(at).starts_with("\"\""))) {
      cell += line[at];
      at += line[at] == '"' ? 2 : 1;
    }
    if (at >= line.size()) return std::nullopt;
    ++at;
  }
  const auto end = std::min(line.find(separator, at), line.size());
  const std::string_view rest = trimmed(line.substr(at, end - at));
  if (quoted && !rest.empty()) return std::nullopt;
  if (!quoted) cell = rest;
  more = end < line.size();
  line.remove_prefix(more ? end + 1 : end);
  return cell;
}

auto whole_number(std::uint64_t least, std::uint64_t most) {
  return [least, most](std::string_view text, std::string_view what) -> Result<std::uint64_t> {
    const bool hex = text.starts_with("0x") || text.starts_with("0X");
    const auto value = hex ? number_in<std::uint64_t>(text.substr(2), kHexadecimalBase)
                           : number_in<std::uint64_t>(text);
    if (!value || *value < least || *value > most)
      return fail(fmt::format("{} '{}': must be a whole number from {} to {}, decimal or 0x…", what,
                              text, least, most));
    return *value;
  };
}

/// The error with the text of the file in place of `number`, which was converted from it.
std::string quoted_as(std::string error, std::string_view number, std::string_view text) {
  if (const auto at = error.find(number); at != std::string::npos)
    error.replace(at, number.size(), text);
  return error;
}

Result<bool> yes_or_no(std::string_view text, std::string_view what) {
  const std::string small = in_small_letters(text);  // spreadsheets write TRUE
  if (small == "1" || small == "true") return true;
  if (small == "0" || small == "false") return false;
  return fail(fmt::format("{} '{}': must be 0, 1, true or false", what, text));
}

/// The encoding that a byte order mark or the first character shows, if it is not UTF-8; else
/// empty.
std::string_view other_encoding(std::string_view text) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) return "UTF-16";
  if (text.size() < 2) return {};
  if (text[0] != '\0' && text[1] == '\0') return "UTF-16LE";
  return text[0] == '\0' && text[1] != '\0' ? "UTF-16BE" : "";
}

/// The separator for a message: "','" or "tab".
std::string separator_words(char separator) {
  return separator == '\t' ? "tab" : fmt::format("'{}'", separator);
}

/// The number of values in a line with that separator; 0 if its quotes are wrong.
std::size_t values_between(std::string_view line, char separator) {
  std::size_t values = 0;
  for (bool more = true; more; ++values)
    if (!take_cell(line, separator, more)) return 0;
  return values;
}

/// A hint, if a line has another number of values than the header has columns: perhaps another
/// separator.
std::string why_values_wrong(std::size_t values, std::size_t columns, char separator,
                             std::string_view line) {
  char other = separator;
  std::size_t most = 1;
  for (const char c : kSeparators) {
    const std::size_t found = c == separator ? 0 : values_between(line, c);
    if (found <= most || most == columns) continue;
    most = found;
    other = c;
  }
  if (other != separator && (values == 1 || most == columns))
    return fmt::format(" (the columns of the header are separated by {}, those of this line by {})",
                       separator_words(separator), separator_words(other));
  if (other != separator)
    return fmt::format(" (this line has {} too, and the columns of the header are separated by {})",
                       separator_words(other), separator_words(separator));
  if (separator == ',' && values > columns)
    return " (columns are separated by ',', so a number must have a decimal point)";
  return {};
}

std::string values_wrong(std::size_t values, std::size_t columns, bool commented, char separator,
                         std::string_view line) {
  return fmt::format("{}: must be {}, one for each column of the header{}", many(values, "value"),
                     columns,
                     commented ? " (what follows a # is a comment)"
                               : why_values_wrong(values, columns, separator, line));
}

/// A hint about a wrong value that contains a separator other than the one in use; otherwise empty.
std::string other_separator_in(std::string_view value, char separator) {
  for (const char c : kSeparators) {
    if (c == separator || !value.contains(c)) continue;
    return c == ',' ? fmt::format(" (where columns are separated by {}, ',' is a decimal comma)",
                                  separator_words(separator))
                    : fmt::format(" (the columns of the header are separated by {}, not by {})",
                                  separator_words(separator), separator_words(c));
  }
  return {};
}

/// A hint about a column name that contains another separator; otherwise empty.
std::string second_separator_in(const std::vector<std::string>& names, char separator) {
  for (const std::string& name : names)
    if (const char other = separator_of(name); name.contains(other))
      return fmt::format(" (this line has {} and {}: all columns must be separated by one)",
                         separator_words(separator), separator_words(other));
  return {};
}

class TableReader {
 public:
  TableReader(const std::string& file, const BusOptions& options) : file_(file) {
    at_.fill(kMissing);
    bus_.assumptions.timing = {.bitrate = options.bitrate, .data_bitrate = options.data_bitrate};
    bus_.assumptions.fd_frames = options.data_bitrate > 0;
    bus_.assumptions.unknown_senders = options.unknown_senders;
    bus_.assumptions.background = options.background.value_or(0);
    bus_.assumptions.faults = options.faults.value_or(core::FaultHypothesis{});
  }

  Buses read(std::string_view text) && {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    if (const auto encoding = other_encoding(text); !encoding.empty()) {
      problem("header", fmt::format("the table is {}: save it as UTF-8", encoding));
      return {{}, std::move(problems_)};
    }
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    while (!text.empty() && readable_) {
      const auto end = std::min(text.find('\n'), text.size());
      ++line_;
      const auto whole = text.substr(0, end);
      const auto line = without_comment(whole);
      commented_ = line.size() != whole.size();
      take(line);
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (!header_)
      problem("header", fmt::format("no header: the first line must be {}", kHeader));
    else if (problems_.empty() && bus_.messages.empty())
      problem("messages", "no messages: one line for each must follow the header");
    if (problems_.empty()) {
      for (std::string& text_of : problems_of(bus_.messages, {}))
        add_of("identifier or name", std::move(text_of));
    }
    for (const auto& [kind, count] : of_kind_)
      if (count > kMostOfAKind)
        problems_.push_back(
            fmt::format("{}: and {} more of this kind: {}", file_, count - kMostOfAKind, kind));
    if (!problems_.empty()) return {{}, std::move(problems_)};
    Buses buses;
    buses.buses.push_back(std::move(bus_));
    return buses;
  }

 private:
  [[nodiscard]] std::string where() const {
    return fmt::format("{}:{}", file_, std::max<std::size_t>(line_, 1));
  }

  /// Adds a problem, unless kMostOfAKind problems of that kind are listed already.
  void add_of(std::string_view kind, std::string text) {
    if (++of_kind_[std::string(kind)] <= kMostOfAKind) problems_.push_back(std::move(text));
  }
  void problem(std::string_view kind, const std::string& text) {
    ++found_;
    add_of(kind, fmt::format("{}: {}", where(), text));
  }

  void take(std::string_view line) {
    if (trimmed(line).empty()) return;
    if (!header_) separator_ = separator_of(line);
    const std::string_view content = line;
    std::vector<std::string> cells;
    for (bool more = true; more;) {
      auto cell = take_cell(line, separator_, more);
      if (!cell) {
        problem(
            "quotes",
            "quotes are not right: a cell in quotes ends with one, and \"\" is one of the cell");
        readable_ = header_;
        header_ = true;
        return;
      }
      cells.push_back(std::move(*cell));
    }
    if (header_)
      take_message(cells, content);
    else
      take_header(cells);
  }

  void take_header(const std::vector<std::string>& cells) {
    header_ = true;
    columns_ = cells.size();
    std::vector<std::string> unknown;
    std::vector<std::string> twice;
    std::vector<std::string> missing;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto* const column = std::ranges::find(kColumns, in_small_letters(cells[i]));
      if (column == kColumns.end()) {
        unknown.push_back("'" + cells[i] + "'");
        continue;
      }
      std::size_t& at = at_[static_cast<std::size_t>(column - kColumns.begin())];
      if (at != kMissing) twice.push_back(cells[i]);
      at = i;
    }
    for (std::size_t c = 0; c < kRequired; ++c)
      if (at_[c] == kMissing) missing.emplace_back(kColumns[c]);
    if (unknown.empty() && twice.empty() && missing.empty()) return;
    std::string text;
    const auto add = [&text](const std::vector<std::string>& names, std::string_view one,
                             std::string_view several) {
      if (!names.empty())
        text += fmt::format("{}{} {}", text.empty() ? "" : "; ", names.size() == 1 ? one : several,
                            listed(names));
    };
    add(missing, "there is no column", "there are no columns");
    add(unknown, "unknown column", "unknown columns");
    add(twice, "there twice:", "there twice:");
    problem("header", fmt::format("{}{}. The header must be {}, between commas, semicolons, tabs "
                                  "or bars",
                                  text, second_separator_in(cells, separator_), kHeader));
    // Without the columns no line can be read.
    readable_ = false;
  }

  /// Converts a cell with `read`, which gets the cell and the name of its column. An error becomes
  /// a problem, and the value is empty then.
  template <class Read>
  auto get(std::string_view column, std::string_view cell, const Read& read) {
    auto value = read(cell, column);
    if (!value) {
      problem(column, value.error().text + other_separator_in(cell, separator_));
      value.emplace();
    }
    return *value;
  }

  void take_message(const std::vector<std::string>& cells, std::string_view line) {
    if (cells.size() != columns_) {
      problem("values", values_wrong(cells.size(), columns_, commented_, separator_, line));
      return;
    }
    const std::size_t problems = found_;
    const auto cell = [&](Field f) {
      const std::size_t at = at_[static_cast<std::size_t>(f)];
      return at == kMissing ? std::string_view{} : std::string_view(cells[at]);
    };
    BusMessage m;
    m.name = cell(Field::name);
    m.where = where();
    if (m.name.empty()) problem("name", "name is empty: each message needs one");
    m.extended = get("extended", cell(Field::extended), yes_or_no);
    const bool fd = !cell(Field::fd).empty() && get("fd", cell(Field::fd), yes_or_no);
    // A wrong value of extended or fd is reported once, not also as a wrong id or size.
    const bool forms_known = found_ == problems;
    if (fd && bus_.assumptions.timing.data_bitrate == 0)
      problem("FD frames",
              "fd: how long an FD frame takes needs --data-bitrate, the bit rate of its data phase "
              "(that of --bitrate where it does not change)");
    const std::uint32_t most_id = m.extended || !forms_known ? 0x1fffffff : 0x7ff;
    m.id = static_cast<std::uint32_t>(get("id", cell(Field::id), whole_number(0, most_id)));
    m.bytes = get("bytes", cell(Field::bytes), whole_number(0, fd || !forms_known ? 64 : 8));
    core::can::Message& message = m.message;
    constexpr std::uint64_t most_frames = 65536;
    if (!cell(Field::frames).empty())
      message.frames = static_cast<std::uint32_t>(
          get("frames", cell(Field::frames), whole_number(1, most_frames)));
    message.period = time_of(cell(Field::period), Rounding::down, true, "period_us");
    message.deadline = cell(Field::deadline).empty()
                           ? message.period
                           : time_of(cell(Field::deadline), Rounding::down, true, "deadline_us");
    if (!cell(Field::jitter).empty())
      message.jitter = time_of(cell(Field::jitter), Rounding::up, false, "jitter_us");
    if (message.jitter > core::can::kLongestTime)
      problem("jitter_us", fmt::format("jitter_us '{}': must be at most {}, nothing on the bus is "
                                       "bounded otherwise",
                                       cell(Field::jitter), core::can::kLongestTime / 1000));
    if (found_ != problems) return;
    if (fd) bus_.assumptions.fd_frames = true;
    m.node = cell(Field::node);
    if (!m.node.empty()) message.queue = queue_of(m.node);
    message.key = bus_.messages.size();
    message.priority = core::can::arbitration(m.id, m.extended);
    message.longest_frame = message.last_frame =
        frame_time(bus_.assumptions.timing, {.extended = m.extended, .fd = fd},
                   static_cast<unsigned>(*m.bytes));
    message.transmission = message.frames * message.longest_frame;
    bus_.messages.push_back(std::move(m));
  }

  /// The FIFO of a node. Its length is not stated, so it counts as long enough.
  std::uint32_t queue_of(const std::string& node) {
    const auto [it, fresh] =
        queues_.try_emplace(node, static_cast<std::uint32_t>(bus_.assumptions.queues.size()));
    if (fresh)
      bus_.assumptions.queues.push_back(
          {.queueing = core::Queueing::fifo, .length = std::numeric_limits<std::uint32_t>::max()});
    return it->second;
  }

  std::uint64_t time_of(std::string_view text, Rounding rounding, bool positive,
                        std::string_view what) {
    // With another separator, a comma is a decimal comma, as in many countries.
    std::string number(text);
    const bool has_comma = number.contains(',');
    if (has_comma && separator_ != ',') std::ranges::replace(number, ',', '.');
    const auto time = parse_microseconds(number, rounding);
    if (has_comma && separator_ == ',')
      problem(what, fmt::format("{} '{}': must have a decimal point: columns are separated by ','",
                                what, text));
    else if (has_comma && std::ranges::count(number, '.') > 1)
      problem(what, fmt::format("{} '{}': must have one decimal point or comma, and none between "
                                "thousands",
                                what, text));
    else if (!time)
      problem(what, fmt::format("{} {}{}", what, quoted_as(time.error().text, number, text),
                                has_comma ? "" : other_separator_in(text, separator_)));
    else if (positive && *time == 0)
      problem(what, fmt::format("{} '{}': must be 0.001 (1 ns) or more", what, text));
    else
      return *time;
    return 0;
  }

  const std::string& file_;
  Bus bus_;
  std::vector<std::string> problems_;
  std::array<std::size_t, kColumns.size()> at_{};  ///< the column of each Field
  std::map<std::string, std::uint32_t> queues_;    ///< by name of the node
  std::map<std::string, std::size_t> of_kind_;     ///< problems by kind
  std::size_t found_ = 0;                          ///< number of problems
  std::size_t columns_ = 0;
  std::size_t line_ = 0;
  char separator_ = ',';
  bool header_ = false;
  bool commented_ = false;  ///< the present line ends with a comment
  bool readable_ = true;
};

}  // namespace

Buses read_table(std::string_view text, const std::string& file, const BusOptions& options) {
  return TableReader(file, options).read(text);
}

}  // namespace mlcca::tools::design
