// SPDX-License-Identifier: BSD-2-Clause
// The readers of each format of recordings; see recording.hpp.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/learn/input.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {

/// What each reader gets. An error of it has no name of the file yet: "line 7: …".
struct Recording {
  Input& input;
  Interfaces& interfaces;
  const OnFrame& on_frame;
  std::string stem;  ///< of the file's name: what formats without interface names call theirs
  Left left{};
  std::uint64_t handed_over = 0;  ///< frames

  /// Something that is no frame, and is passed over.
  void pass_over(const std::string& what) {
    if (left.lines++ == 0) left.first = what;
  }
  /// The file ends within something, as it does when its writer was ended: what is complete counts.
  Result<void> cut(const std::string& where) {
    if (handed_over == 0) return fail(where);
    pass_over(where);
    return {};
  }
  /// Hands the frame over, unless its interface is one too many, or no frame can have its
  /// identifier.
  void take(const Frame& frame) {
    if (!frame.datagram && !frame.is_extended() && (frame.id & kIdentifierBits) > 0x7ff)
      pass_over("an identifier of 11 bits above 0x7ff");
    else if (frame.interface >= Interfaces::kMost)
      ++left.interfaces;
    else {
      ++handed_over;
      on_frame(frame);
    }
  }
};

Result<void> read_candump(Recording& recording);
Result<void> read_candump_screen(Recording& recording);
Result<void> read_asc(Recording& recording);
Result<void> read_blf(Recording& recording);
Result<void> read_pcap(Recording& recording);
Result<void> read_pcapng(Recording& recording);

/// The lines of a text, one after the other, without its end. Those of more than 4096 bytes are
/// longer than any format has, and may be cut.
class Lines {
 public:
  static constexpr std::size_t kLongest = 4096;
  explicit Lines(Input& input) : input_(&input) {}
  /// Of the beginning of a text, whose last line may be cut.
  explicit Lines(Bytes head) : rest_(text_of(head)) {}
  /// False at the end. The line is valid until the next call.
  bool next() {
    auto end = rest_.find('\n');
    if (end == std::string_view::npos) end = fill();
    if (rest_.empty()) return false;
    ++number_;
    line_ = rest_.substr(0, end);
    const std::size_t size = end == std::string_view::npos ? rest_.size() : end + 1;
    rest_.remove_prefix(size);
    offset_ += size;
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    return true;
  }
  [[nodiscard]] std::string_view line() const { return line_; }
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  static std::string_view text_of(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()),
            bytes.size()};  // NOLINT(*-reinterpret-cast)
  }
  /// Where the line ends that rest_ begins, once there is more of it.
  std::size_t fill() {
    while (input_ != nullptr && rest_.size() <= kLongest) {
      const std::size_t before = rest_.size();
      rest_ = text_of(input_->from(offset_, before + 1));
      if (rest_.size() <= before) return std::string_view::npos;
      if (const auto end = rest_.find('\n', before); end != std::string_view::npos) return end;
    }
    return std::string_view::npos;
  }

  Input* input_ = nullptr;
  std::uint64_t offset_ = 0;  ///< of rest_
  std::string_view rest_;
  std::string_view line_;
  std::uint64_t number_ = 0;
};

/// What candump shows on a screen, or what cansend takes, as the first line says.
enum class Screen : std::uint8_t { none, with_times, with_dates, without_times };
Screen screen_of(Bytes head);
/// "123#1122"
bool is_candump_frame(std::string_view word);
/// "(1436509052.249713)" in ns; false: it is no time.
bool take_candump_time(std::string_view word, std::uint64_t& ns);
/// Error: the line is longer than any of candump.
Result<void> check_candump_length(const Lines& lines);
/// The line is no frame: "line 3: 'hello' is no frame …".
void pass_over_line(Recording& recording, const Lines& lines, std::string_view why);

/// A frame of SocketCAN in a packet: an identifier in big-endian order, length, flags, two bytes,
/// data. False: it is none.
bool take_socketcan(Bytes packet, std::uint64_t ns, std::uint32_t interface, bool local,
                    Recording& recording);

/// Reads numbers in the order of the file, or nothing beyond its end.
template <class Number>
Number number_at(Bytes bytes, std::size_t at, bool big_endian) {
  Number out = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    const auto from = big_endian ? i : sizeof(Number) - 1 - i;
    out = static_cast<Number>(out << 8 | bytes[at + from]);
  }
  return out;
}

/// Cuts the next word off a line: what is before a blank or a tab. Empty: there is none.
std::string_view next_word(std::string_view& line);

}  // namespace mlcca::learn
