// SPDX-License-Identifier: BSD-2-Clause
// Reader for logs of Vector tools in text form:
//
//   date Wed Apr 20 10:10:10 am 2016
//   base hex  timestamps absolute
//      2.501000 1  223             Rx   d 4 01 02 03 04
//      2.502000 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40
//      2.503000 CANFD   1 Rx  223  1 0 d 16 01 02 …
//
// Some lines have the name of a message instead of its identifier, which then is at their end:
//
//      2.504000 1  EngineData      Rx   d 2 01 02  Length = 135910 BitCount = 70 ID = 547
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/ascii.hpp"
#include "base/decimal.hpp"
#include "base/number.hpp"
#include "tools/learn/formats.hpp"

namespace mlcca::learn {
namespace {

/// Marks a frame that a program wanted to send. There is another line for it when it is on the bus.
constexpr std::string_view kAskedFor = "TxRq";

class Asc {
 public:
  explicit Asc(Recording& recording) : recording_(recording), lines_(recording.input) {}

  Result<void> read() {
    while (lines_.next()) {
      if (is_long_line(recording_, lines_)) continue;
      std::string_view line = lines_.line();
      const auto first = next_word(line);
      if (first == "base") take_base(line);
      if (first.empty() || is_of_head(first)) continue;
      if (const auto ns = time_of(first))
        take_event(*ns, line);
      else if (!is_cut_line(recording_, lines_))
        pass_over_line(recording_, lines_, "begins with no time, and with no word of a header");
    }
    return {};
  }

 private:
  /// Whether a line that begins with this word has no event.
  static bool is_of_head(std::string_view word) {
    constexpr auto words = std::to_array<std::string_view>(
        {"date", "base", "internal", "no", "previous", "Begin", "End", "begin", "end"});
    return word.starts_with("//") || std::ranges::find(words, word) != words.end();
  }

  /// A time in seconds, as ns. Some countries write it with a comma.
  static std::optional<std::uint64_t> time_of(std::string_view word) {
    if (std::isdigit(static_cast<unsigned char>(word[0])) == 0) return std::nullopt;
    std::string text(word);
    if (const auto comma = text.find(','); comma != std::string::npos) text[comma] = '.';
    const auto time = Decimal::read(text);
    return time ? time->scaled(9, false) : std::nullopt;
  }

  /// Reads a line such as "hex  timestamps absolute".
  void take_base(std::string_view line) {
    base_ = next_word(line) == "dec" ? kDecimalBase : kHexadecimalBase;
    next_word(line);
    relative_ = next_word(line) == "relative";
  }

  template <class Number>
  [[nodiscard]] std::optional<Number> number(std::string_view text, int base) const {
    return number_in<Number>(text, base);
  }

  void take_event(std::uint64_t ns, std::string_view line) {
    now_ = relative_ ? now_ + ns : ns;
    const auto first = next_word(line);
    bool done = true;
    if (first == "CANFD")
      done = take_fd(line);
    else if (number<unsigned>(first, kDecimalBase))
      done = take_classic(first, line);
    if (!done) pass_over("an event that is no CAN frame");
  }

  void pass_over(const std::string& what) {
    if (is_cut_line(recording_, lines_)) return;
    recording_.pass_over("line " + std::to_string(lines_.number()) + ": " + what);
  }

  [[nodiscard]] std::optional<std::uint32_t> identifier(std::string_view word, int base) const {
    const bool extended = word.ends_with('x');
    if (extended) word.remove_suffix(1);
    const auto id = number<std::uint32_t>(word, base);
    if (!id || *id > (extended ? kIdentifierBits : 0x7ffU)) return std::nullopt;
    return *id | (extended ? kExtended : 0);
  }

  /// The identifier of a frame. If the word is or may be a name ("AB"), it is the decimal number
  /// after "ID =".
  [[nodiscard]] std::optional<std::uint32_t> identifier_of(std::string_view word,
                                                           std::string_view rest) const {
    constexpr std::string_view before = " ID = ";
    const auto written = identifier(word, base_);
    const auto at = rest.find(before);
    if (at == std::string_view::npos || (written && std::ranges::any_of(word, is_digit)))
      return written;
    rest.remove_prefix(at + before.size());
    const auto stated = identifier(next_word(rest), kDecimalBase);
    return stated ? stated : written;
  }

  /// Reads `size` bytes, each of which is one word.
  bool take_data(std::string_view& line, std::size_t size, Frame& frame) {
    if (size > data_.size()) return false;
    for (std::size_t i = 0; i < size; ++i) {
      const auto byte = number<unsigned>(next_word(line), base_);
      if (!byte || *byte > 0xff) return false;
      data_[i] = static_cast<std::uint8_t>(*byte);
    }
    frame.data = {data_.data(), size};
    return true;
  }

  void hand_over(Frame& frame, std::string_view channel) {
    frame.ns = now_;
    if (channel != channel_) {
      channel_ = channel;
      number_ = recording_.interfaces.number_of_made_up("can" + std::string(channel));
    }
    frame.interface = number_;
    recording_.take(frame);
  }

  bool take_classic(std::string_view channel, std::string_view line) {
    Frame frame;
    const auto word = next_word(line);
    if (word == "ErrorFrame") ++recording_.left.errors;
    if (word == "ErrorFrame" || word == "Statistic:") return true;
    const auto direction = next_word(line);
    const auto kind = next_word(line);
    if (direction == kAskedFor) return true;
    if (kind == "d") {
      const auto size = number<std::size_t>(next_word(line), kHexadecimalBase);
      if (!size || !take_data(line, std::min<std::size_t>(*size, 8), frame)) return false;
    } else if (kind != "r") {
      return false;
    }
    const auto id = identifier_of(word, line);
    if (!id && direction != "Rx" && direction != "Tx") return false;
    if (!id) {
      pass_over("the message " + std::string(word.substr(0, 60)) +
                " has a name and no identifier: record identifiers, as numbers");
      return true;
    }
    frame.id = *id | (kind == "r" ? kRemote : 0);
    frame.local = direction == "Tx";
    hand_over(frame, channel);
    return true;
  }

  bool take_fd(std::string_view line) {
    const auto channel = next_word(line);
    if (!number<unsigned>(channel, kDecimalBase)) return false;
    Frame frame;
    frame.fd = true;
    const auto direction = next_word(line);
    if (direction == kAskedFor) return true;
    frame.local = direction == "Tx";
    const auto id = identifier(next_word(line), base_);
    if (!id) return false;
    frame.id = *id;
    auto word = next_word(line);  // the bit-rate switch, or the name of the message before it
    if (word != "0" && word != "1") word = next_word(line);
    next_word(line);  // the error state
    next_word(line);  // the length code
    const auto size = number<std::size_t>(next_word(line), kDecimalBase);
    if (!size || !take_data(line, *size, frame)) return false;
    hand_over(frame, channel);
    return true;
  }

  Recording& recording_;
  Lines lines_;
  int base_ = kHexadecimalBase;
  bool relative_ = false;
  std::uint64_t now_ = 0;
  std::string channel_;
  std::uint32_t number_ = 0;
  std::array<std::uint8_t, 64> data_{};
};

}  // namespace

Result<void> read_asc(Recording& recording) { return Asc(recording).read(); }

}  // namespace mlcca::learn
