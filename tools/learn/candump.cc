// SPDX-License-Identifier: BSD-2-Clause
// Reader for logs of candump -l: "(1436509052.249713) can0 123#1122". FD frames are 123##1AABB,
// with their flags in one digit, and remote frames 123#R or 123#R8. With -x, lines end with R
// (received) or T (sent).
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/number.hpp"
#include "tools/learn/formats.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostData = 64;
constexpr std::size_t kClassic = 8;

/// Hexadecimal or decimal digits at the start of a word: how many there are, and their value. None
/// if they do not fit.
struct Digits {
  std::uint64_t value = 0;
  std::size_t count = 0;
};
Digits digits_at(std::string_view text, int base) {
  std::string_view rest = text;
  const auto value = take_number<std::uint64_t>(rest, base);
  return {.value = value.value_or(0), .count = text.size() - rest.size()};
}

/// Cuts an identifier such as "123" or "18FEF100", and the '#' after it, off the word. False if it
/// is not one.
bool take_identifier(std::string_view& word, std::uint32_t& id) {
  constexpr std::size_t standard = 3;
  constexpr std::size_t extended = 8;
  const Digits digits = digits_at(word, kHexadecimalBase);
  const std::size_t at = digits.count;
  if ((at != standard && at != extended) || at == word.size() || word[at] != '#') return false;
  id = static_cast<std::uint32_t>(digits.value);
  if (at == extended && (id & kError) == 0) id = (id & kIdentifierBits) | kExtended;
  word.remove_prefix(at + 1);
  return at == extended || id <= 0x7ff;
}

/// The number of data bytes such as "1122", with or without dots in between; nullopt if they are
/// not data.
std::optional<std::size_t> take_data(std::string_view word, std::size_t most,
                                     std::array<std::uint8_t, kMostData>& data) {
  std::size_t size = 0;
  while (!word.empty()) {
    if (word.starts_with('.')) word.remove_prefix(1);
    if (word.starts_with('_') && most == kClassic && size == most) break;  // a length code above 8
    if (word.size() < 2 || size == most) return std::nullopt;
    const auto byte = number_in<std::uint8_t>(word.substr(0, 2), kHexadecimalBase);
    if (!byte) return std::nullopt;
    data[size++] = *byte;
    word.remove_prefix(2);
  }
  return size;
}

/// Reads a frame such as "123#1122". False if it is not one.
bool take_frame(std::string_view word, Frame& frame, std::array<std::uint8_t, kMostData>& data) {
  if (!take_identifier(word, frame.id)) return false;
  frame.fd = word.starts_with('#');
  if (frame.fd) {
    if (!number_in<std::uint8_t>(word.substr(1, 1), kHexadecimalBase)) return false;
    word.remove_prefix(2);
  }
  if (!frame.fd && word.starts_with('R')) {
    frame.id |= kRemote;
    return word.size() <= 3;
  }
  const auto size = take_data(word, frame.fd ? kMostData : kClassic, data);
  if (size) frame.data = {data.data(), *size};
  return size.has_value();
}

}  // namespace

bool is_candump_frame(std::string_view word) {
  Frame frame;
  std::array<std::uint8_t, kMostData> data{};
  return take_frame(word, frame, data);
}

bool take_candump_time(std::string_view word, std::uint64_t& ns) {
  if (!word.starts_with('(') || !word.ends_with(')')) return false;
  word = word.substr(1, word.size() - 2);
  const Digits seconds = digits_at(word, kDecimalBase);
  if (seconds.count == 0 || seconds.count > 10) return false;
  ns = seconds.value * 1'000'000'000;
  word.remove_prefix(seconds.count);
  if (word.empty()) return true;
  word.remove_prefix(1);
  const Digits fraction = digits_at(word, kDecimalBase);
  if (fraction.count == 0 || fraction.count != word.size() || fraction.count > 9) return false;
  std::uint64_t part = fraction.value;
  for (std::size_t i = fraction.count; i < 9; ++i) part *= 10;
  ns += part;
  return true;
}

bool is_long_line(Recording& recording, const Lines& lines) {
  if (!lines.is_long()) return false;
  if (!is_cut_line(recording, lines))
    recording.pass_over("line " + std::to_string(lines.number()) + " has more than " +
                        std::to_string(Lines::kLongest) + " characters: no line is so long");
  return true;
}

bool is_cut_line(Recording& recording, const Lines& lines) {
  if (!lines.is_open() || recording.handed_over == 0) return false;
  return recording.cut("the file ends within line " + std::to_string(lines.number())).has_value();
}

void pass_over_line(Recording& recording, const Lines& lines, std::string_view why) {
  recording.pass_over("line " + std::to_string(lines.number()) + ": '" +
                      std::string(lines.line().substr(0, 60)) + "' " + std::string(why));
}

Result<void> read_candump(Recording& recording) {
  Lines lines(recording.input);
  std::string name;  // name of the latest interface; usually the next line has the same
  std::uint32_t number = 0;
  std::array<std::uint8_t, kMostData> data{};
  while (lines.next()) {
    std::string_view line = lines.line();
    if (is_long_line(recording, lines)) continue;
    Frame frame;
    const auto time = next_word(line);
    if (time.empty()) continue;
    const auto interface = next_word(line);
    const auto text = next_word(line);
    if (!take_candump_time(time, frame.ns) || interface.empty() || !take_frame(text, frame, data)) {
      if (is_cut_line(recording, lines)) break;
      pass_over_line(recording, lines,
                     "is no frame as candump -l writes it: (1436509052.249713) can0 123#1122");
      continue;
    }
    if (interface != name) {
      number = recording.interfaces.number_of(interface);
      name = interface;
    }
    frame.interface = number;
    frame.local = next_word(line) == "T";
    recording.take(frame);
  }
  return {};
}

}  // namespace mlcca::learn
