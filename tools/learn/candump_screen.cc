// SPDX-License-Identifier: BSD-2-Clause
// Reader for the output of candump on a screen: " (1436509052.249713)  can0  123   [2]  11 22". FD
// frames have two digits in the brackets, remote frames "[2]  remote request". With -x, "RX - -" or
// "TX - -" follows the interface. Times must be those of -ta or -tz.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/number.hpp"
#include "tools/learn/formats.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostShown = 64;
constexpr std::size_t kClassicShown = 8;
/// The brackets of a frame: "[8]", or "[08]" for an FD frame.
struct Brackets {
  std::size_t bytes = 0;
  bool fd = false;
};
std::optional<Brackets> brackets_of(std::string_view word) {
  if (word.size() < 3 || word.size() > 4 || word.front() != '[' || word.back() != ']')
    return std::nullopt;
  const auto digits = word.substr(1, word.size() - 2);
  const auto bytes = number_in<unsigned>(digits);
  const bool fd = digits.size() == 2;
  if (!bytes || *bytes > (fd ? kMostShown : kClassicShown)) return std::nullopt;
  return Brackets{*bytes, fd};
}

/// Reads an identifier such as "123" or "18FEF100".
std::optional<std::uint32_t> identifier_of(std::string_view word) {
  constexpr std::size_t standard = 3;
  constexpr std::size_t extended = 8;
  const auto id = number_in<std::uint32_t>(word, kHexadecimalBase);
  if (!id || (word.size() != standard && word.size() != extended)) return std::nullopt;
  if (word.size() == extended && (*id & kError) == 0) return (*id & kIdentifierBits) | kExtended;
  return id;
}

using Shown = std::array<std::uint8_t, kMostShown>;

/// Reads the part of a line after the time. False if it is not a frame.
bool take_shown(std::string_view line, std::string_view& interface, Frame& frame, Shown& data) {
  interface = next_word(line);
  auto word = next_word(line);
  if (word == "RX" || word == "TX") {
    frame.local = word == "TX";
    next_word(line);
    next_word(line);
    word = next_word(line);
  }
  const auto id = identifier_of(word);
  const auto brackets = brackets_of(next_word(line));
  if (interface.empty() || !id || !brackets) return false;
  frame.id = *id;
  frame.fd = brackets->fd;
  for (std::size_t i = 0; i < brackets->bytes; ++i) {
    word = next_word(line);
    if (i == 0 && word == "remote") {
      frame.id |= kRemote;
      return true;
    }
    const auto byte =
        word.size() == 2 ? number_in<std::uint8_t>(word, kHexadecimalBase) : std::nullopt;
    if (!byte) return false;
    data[i] = *byte;
  }
  if (brackets->bytes == 0 && next_word(line) == "remote") frame.id |= kRemote;
  frame.data = {data.data(), brackets->bytes};
  return true;
}

/// The first line that is not empty.
std::string_view first_line(Bytes bytes) {
  Lines lines(bytes.first(std::min<std::size_t>(bytes.size(), Lines::kLongest)));
  while (lines.next()) {
    std::string_view line = lines.line();
    if (!next_word(line).empty()) return lines.line();
  }
  return {};
}

/// Whether a line is like those of candump -L without the time: "can0 123#1122", or only the frame.
bool is_frame_alone(std::string_view line) {
  const auto first = next_word(line);
  if (first.starts_with('(')) return false;
  return is_candump_frame(first) || is_candump_frame(next_word(line));
}

bool is_shown_frame(std::string_view behind_time) {
  std::string_view interface;
  Frame frame;
  Shown data;
  return take_shown(behind_time, interface, frame, data);
}

/// Whether the times of a text are differences between frames: then most of them do not increase.
bool are_between_frames(Bytes bytes) {
  constexpr std::size_t most = 1000;
  Lines lines(bytes);
  std::uint64_t before = 0;
  std::size_t steps = 0;
  std::size_t smaller = 0;
  for (std::size_t i = 0; i < most && lines.next(); ++i) {
    std::string_view line = lines.line();
    std::uint64_t ns = 0;
    if (!take_candump_time(next_word(line), ns)) continue;
    if (ns >= kFirstDate) return false;
    ++steps;
    if (ns < before || (ns == before && steps > 1)) ++smaller;
    before = ns;
  }
  return smaller * 10 > steps;
}

constexpr std::size_t kHeadOfText = std::size_t{64}
                                    << 10U;  // length of the text in which times are compared
constexpr const char* kInstead = ": record with candump -l, or with candump -ta";

}  // namespace

Screen screen_of(Bytes head) {
  std::string_view line = first_line(head);
  if (is_shown_frame(line) || is_frame_alone(line)) return Screen::without_times;
  const std::string_view time = next_word(line);
  if (!time.starts_with('(')) return Screen::none;
  if (is_shown_frame(line)) return Screen::with_times;
  // "(2023-11-14 22:13:20.123456)"
  return next_word(line).ends_with(')') && is_shown_frame(line) ? Screen::with_dates : Screen::none;
}

Result<void> read_candump_screen(Recording& recording) {
  Bytes head = recording.input.from(0, kHeadOfText);
  head = head.first(std::min(head.size(), kHeadOfText));
  const Screen screen = screen_of(head);
  if (screen == Screen::without_times)
    return fail(std::string("lines of candump without time stamps") + kInstead);
  if (screen == Screen::with_dates)
    return fail(std::string("lines of candump with dates (-tA)") + kInstead);
  if (are_between_frames(head))
    return fail(std::string("lines of candump with the times between frames (-td)") + kInstead);
  Lines lines(recording.input);
  Shown data{};
  while (lines.next()) {
    std::string_view line = lines.line();
    if (is_long_line(recording, lines)) continue;
    Frame frame;
    const auto time = next_word(line);
    if (time.empty()) continue;
    std::string_view interface;
    if (!take_candump_time(time, frame.ns) || !take_shown(line, interface, frame, data)) {
      if (is_cut_line(recording, lines)) break;
      pass_over_line(recording, lines,
                     "is no frame as candump -ta shows it: (1436509052.249713)  can0  123   "
                     "[2]  11 22");
      continue;
    }
    frame.interface = recording.interfaces.number_of(interface);
    recording.take(frame);
  }
  return {};
}

}  // namespace mlcca::learn
