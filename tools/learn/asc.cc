// SPDX-License-Identifier: BSD-2-Clause
// Logs of Vector tools in text:
//
//   date Wed Apr 20 10:10:10 am 2016
//   base hex  timestamps absolute
//      2.501000 1  223             Rx   d 4 01 02 03 04
//      2.502000 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40
//      2.503000 CANFD   1 Rx  223  1 0 d 16 01 02 …
#include <array>
#include <cctype>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "tools/learn/formats.hpp"

namespace mlcca::learn {
namespace {

class Asc {
 public:
  explicit Asc(Recording& recording) : recording_(recording), lines_(recording.bytes) {}

  Result<void> read() {
    while (lines_.next()) {
      if (lines_.line().size() > Lines::kLongest)
        return fail("line " + std::to_string(lines_.number()) + " has " +
                    std::to_string(lines_.line().size()) + " characters: no line is so long");
      std::string_view line = lines_.line();
      const auto first = next_word(line);
      if (first == "base") take_base(line);
      if (first.empty() || std::isdigit(static_cast<unsigned char>(first[0])) == 0) continue;
      if (const auto time = Decimal::read(first))
        if (const auto ns = time->scaled(9, false)) take_event(*ns, line);
    }
    return {};
  }

 private:
  /// "hex  timestamps absolute"
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
    if (!done)
      recording_.pass_over("line " + std::to_string(lines_.number()) +
                           ": an event that is no CAN frame");
  }

  bool take_identifier(std::string_view word, Frame& frame) const {
    const bool extended = word.ends_with('x');
    if (extended) word.remove_suffix(1);
    const auto id = number<std::uint32_t>(word, base_);
    if (!id || *id > (extended ? kIdentifierBits : 0x7ffU)) return false;
    frame.id = *id | (extended ? kExtended : 0);
    return true;
  }

  /// So many bytes, each a word.
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
    const auto id = next_word(line);
    if (id == "ErrorFrame" || id == "Statistic:") return true;
    if (!take_identifier(id, frame)) return false;
    frame.local = next_word(line) == "Tx";
    const auto kind = next_word(line);
    if (kind == "r") {
      frame.id |= kRemote;
    } else {
      const auto size = number<std::size_t>(next_word(line), kHexadecimalBase);
      if (kind != "d" || !size || !take_data(line, std::min<std::size_t>(*size, 8), frame))
        return false;
    }
    hand_over(frame, channel);
    return true;
  }

  bool take_fd(std::string_view line) {
    const auto channel = next_word(line);
    if (!number<unsigned>(channel, kDecimalBase)) return false;
    Frame frame;
    frame.fd = true;
    frame.local = next_word(line) == "Tx";
    if (!take_identifier(next_word(line), frame)) return false;
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
  std::string_view channel_;
  std::uint32_t number_ = 0;
  std::array<std::uint8_t, 64> data_{};
};

}  // namespace

Result<void> read_asc(Recording& recording) { return Asc(recording).read(); }

}  // namespace mlcca::learn
