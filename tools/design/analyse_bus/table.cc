// SPDX-License-Identifier: BSD-2-Clause
// Messages from a table of comma-separated values.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>

#include "core/result.hpp"
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
};
constexpr std::array<std::string_view, 9> kColumns = {
    "name", "id", "extended", "bytes", "period_us", "deadline_us", "jitter_us", "fd", "frames"};
constexpr std::size_t kRequired = 7;  // the first ones
constexpr std::size_t kMissing = ~std::size_t{0};
constexpr std::string_view kHeader = "name,id,extended,bytes,period_us,deadline_us,jitter_us";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::string_view unquoted(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    return text.substr(1, text.size() - 2);
  return text;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    // A comma in quotes is one of the cell.
    const auto begin = line.find_first_not_of(" \t");
    const bool quoted = begin != std::string_view::npos && line[begin] == '"';
    const auto close = quoted ? line.find('"', begin + 1) : std::string_view::npos;
    const auto comma = line.find(',', close == std::string_view::npos ? 0 : close);
    cells.push_back(unquoted(trimmed(line.substr(0, comma))));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

Result<std::uint64_t> whole_number(std::string_view text, std::uint64_t least, std::uint64_t most,
                                   std::string_view what) {
  int base = 10;
  std::string_view digits = text;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    digits.remove_prefix(2);
  }
  std::uint64_t value = 0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
  if (error != std::errc{} || end != digits.data() + digits.size() || value < least || value > most)
    return fail(fmt::format("{} '{}': must be a whole number from {} to {}, decimal or 0x…", what,
                            text, least, most));
  return value;
}

Result<bool> yes_or_no(std::string_view text, std::string_view what) {
  if (text == "1" || text == "true") return true;
  if (text == "0" || text == "false") return false;
  return fail(fmt::format("{} '{}': must be 0, 1, true or false", what, text));
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
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    while (!text.empty() && readable_) {
      const auto end = std::min(text.find('\n'), text.size());
      ++line_;
      take(trimmed(text.substr(0, end)));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (!header_)
      problem(fmt::format("no header: the first line must be {}", kHeader));
    else if (problems_.empty() && bus_.messages.empty())
      problem("no messages: one line for each must follow the header");
    if (!problems_.empty()) return {{}, std::move(problems_)};
    Buses buses;
    buses.buses.push_back(std::move(bus_));
    return buses;
  }

 private:
  void problem(const std::string& text) {
    problems_.push_back(fmt::format("{}:{}: {}", file_, std::max<std::size_t>(line_, 1), text));
  }

  void take(std::string_view line) {
    if (line.empty() || line.front() == '#') return;
    const auto cells = cells_of(line);
    if (header_)
      take_message(cells);
    else
      take_header(cells);
  }

  void take_header(const std::vector<std::string_view>& cells) {
    header_ = true;
    columns_ = cells.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto* const column = std::ranges::find(kColumns, cells[i]);
      if (column == kColumns.end()) {
        problem(
            fmt::format("unknown column '{}': the header must be {}, with fd and frames if "
                        "wanted",
                        cells[i], kHeader));
        continue;
      }
      std::size_t& at = at_[static_cast<std::size_t>(column - kColumns.begin())];
      if (at != kMissing) problem(fmt::format("column {} is there twice: remove one", cells[i]));
      at = i;
    }
    for (std::size_t c = 0; c < kRequired; ++c)
      if (at_[c] == kMissing)
        problem(fmt::format("column {} is missing: the header must be {}", kColumns[c], kHeader));
    // Without the columns no line can be understood.
    readable_ = problems_.empty();
  }

  void take_message(const std::vector<std::string_view>& cells) {
    if (cells.size() != columns_) {
      problem(fmt::format("{} values: must be {}, one for each column of the header", cells.size(),
                          columns_));
      return;
    }
    const std::size_t problems = problems_.size();
    const auto cell = [&](Field f) {
      const std::size_t at = at_[static_cast<std::size_t>(f)];
      return at == kMissing ? std::string_view{} : cells[at];
    };
    BusMessage m;
    m.name = cell(Field::name);
    if (m.name.empty()) problem("name is empty: each message needs one");
    m.extended = get(yes_or_no(cell(Field::extended), "extended"));
    const bool fd = !cell(Field::fd).empty() && get(yes_or_no(cell(Field::fd), "fd"));
    // A wrong value of extended or fd is one problem, not two.
    const bool forms_known = problems_.size() == problems;
    const std::uint32_t most_id = m.extended || !forms_known ? 0x1fffffff : 0x7ff;
    m.id = static_cast<std::uint32_t>(get(whole_number(cell(Field::id), 0, most_id, "id")));
    m.bytes = get(whole_number(cell(Field::bytes), 0, fd || !forms_known ? 64 : 8, "bytes"));
    core::can::Message& message = m.message;
    constexpr std::uint64_t most_frames = 65536;
    if (!cell(Field::frames).empty())
      message.frames = static_cast<std::uint32_t>(
          get(whole_number(cell(Field::frames), 1, most_frames, "frames")));
    message.period = time_of(cell(Field::period), Rounding::down, true, "period_us");
    message.deadline = time_of(cell(Field::deadline), Rounding::down, true, "deadline_us");
    message.jitter = time_of(cell(Field::jitter), Rounding::up, false, "jitter_us");
    if (problems_.size() != problems) return;
    if (fd) bus_.assumptions.fd_frames = true;
    message.key = bus_.messages.size();
    message.priority = core::can::arbitration(m.id, m.extended);
    message.longest_frame = message.last_frame =
        frame_time(bus_.assumptions.timing, {.extended = m.extended, .fd = fd},
                   static_cast<unsigned>(m.bytes));
    message.transmission = message.frames * message.longest_frame;
    bus_.messages.push_back(std::move(m));
  }

  template <class T>
  T get(const Result<T>& value) {
    if (value) return *value;
    problem(value.error().text);
    return T{};
  }

  std::uint64_t time_of(std::string_view text, Rounding rounding, bool positive,
                        std::string_view what) {
    const auto time = parse_microseconds(text, rounding);
    if (!time)
      problem(fmt::format("{} {}", what, time.error().text));
    else if (positive && *time == 0)
      problem(fmt::format("{} '{}': must be more than 0", what, text));
    else
      return *time;
    return 0;
  }

  const std::string& file_;
  Bus bus_;
  std::vector<std::string> problems_;
  std::array<std::size_t, kColumns.size()> at_{};  ///< of each Field
  std::size_t columns_ = 0;
  std::size_t line_ = 0;
  bool header_ = false;
  bool readable_ = true;
};

}  // namespace

Buses read_table(std::string_view text, const std::string& file, const BusOptions& options) {
  return TableReader(file, options).read(text);
}

}  // namespace mlcca::tools::design
