// SPDX-License-Identifier: BSD-2-Clause
// The readers of the formats of recordings, and what several of them use. recording.hpp lists the
// formats.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/learn/input.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {

/// The input and output of a reader. Errors of a reader do not have the file's name: "line 7: …".
struct Recording {
  Input& input;
  Interfaces& interfaces;
  const OnFrame& on_frame;
  std::string
      stem;  ///< name of the file without extensions: the interface of formats that name none
  Left left{};
  std::uint64_t handed_over = 0;  ///< number of frames

  /// Counts a line or record that is not a frame and is skipped.
  void pass_over(const std::string& what) {
    if (left.lines++ == 0) left.first = what;
  }
  /// The file ends within a record, because its writer was killed. What is complete is used; it is
  /// an error only if there was no frame.
  Result<void> cut(const std::string& where) {
    if (handed_over == 0) return fail(where);
    left.cut = where;
    return {};
  }
  /// Passes a frame on, unless it is an error frame, its identifier is impossible or its interface
  /// is beyond Interfaces::kMost.
  void take(const Frame& frame) {
    if (!frame.datagram && (frame.id & kError) != 0)
      ++left.errors;
    else if (!frame.datagram && !frame.is_extended() && (frame.id & kIdentifierBits) > 0x7ff)
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

/// The lines of a text, one after the other, without line ends. Lines of more than 4096 bytes are
/// longer than any format allows: only their beginning is kept.
class Lines {
 public:
  static constexpr std::size_t kLongest = 4096;
  explicit Lines(Input& input) : input_(&input) {}
  /// For the beginning of a text, whose last line may be cut.
  explicit Lines(Bytes head) : rest_(text_of(head)) {}
  /// Reads the next line. False at the end. line() is valid until the next call.
  bool next() {
    auto end = rest_.find('\n');
    if (end == std::string_view::npos) end = fill();
    if (rest_.empty()) return false;
    ++number_;
    line_ = rest_.substr(0, end);
    is_open_ = end == std::string_view::npos;
    const std::size_t size = end == std::string_view::npos ? rest_.size() : end + 1;
    rest_.remove_prefix(size);
    offset_ += size;
    size_ = line_.size();
    if (is_long()) shorten();
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    return true;
  }
  [[nodiscard]] std::string_view line() const { return line_; }
  [[nodiscard]] std::uint64_t number() const { return number_; }
  /// The file ends within it, or has no end of line behind its last line.
  [[nodiscard]] bool is_open() const { return is_open_; }
  /// It is no line of any format.
  [[nodiscard]] bool is_long() const { return size_ > kLongest; }

 private:
  static std::string_view text_of(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()),
            bytes.size()};  // NOLINT(*-reinterpret-cast)
  }
  /// Reads more until the line at the start of rest_ is complete. Returns where it ends; npos if it
  /// does not.
  std::size_t fill() {
    while (input_ != nullptr && rest_.size() <= kLongest) {
      const std::size_t before = rest_.size();
      rest_ = text_of(input_->from(offset_, before + 1));
      if (rest_.size() <= before) return std::string_view::npos;
      if (const auto end = rest_.find('\n', before); end != std::string_view::npos) return end;
    }
    return std::string_view::npos;
  }

  /// Keeps the beginning of a line that is too long, and goes to its end.
  void shorten() {
    beginning_ = line_.substr(0, kLongest);
    line_ = beginning_;
    while (is_open_ && input_ != nullptr) {
      rest_ = text_of(input_->from(offset_, 1));
      if (rest_.empty()) return;
      const auto end = rest_.find('\n');
      is_open_ = end == std::string_view::npos;
      size_ += is_open_ ? rest_.size() : end;
      const std::size_t passed = is_open_ ? rest_.size() : end + 1;
      rest_.remove_prefix(passed);
      offset_ += passed;
    }
  }

  Input* input_ = nullptr;
  std::uint64_t offset_ = 0;  ///< offset of rest_ in the input
  std::string_view rest_;
  std::string_view line_;
  std::string beginning_;  ///< of a line that is too long
  std::size_t size_ = 0;   ///< of the line, bytes
  std::uint64_t number_ = 0;
  bool is_open_ = false;
};

/// What a text is by its first line: output of candump on a screen, or input of cansend (without
/// times).
enum class Screen : std::uint8_t { none, with_times, with_dates, without_times };
Screen screen_of(Bytes head);
/// Whether a word is a frame such as "123#1122".
bool is_candump_frame(std::string_view word);
/// Reads a time such as "(1436509052.249713)" as ns. False if it is not one.
bool take_candump_time(std::string_view word, std::uint64_t& ns);
/// Passes over a line that is longer than any format allows: true if it was one.
bool is_long_line(Recording& recording, const Lines& lines);
/// Skips a line that is not a frame: "line 3: 'hello' is no frame …".
void pass_over_line(Recording& recording, const Lines& lines, std::string_view why);
/// The last line is no frame and has no end: the file is cut off there, behind frames.
[[nodiscard]] bool is_cut_line(Recording& recording, const Lines& lines);

/// Reads a packet of SocketCAN: identifier in big-endian order, length, flags, two bytes, data.
/// False if it is not one.
bool take_socketcan(Bytes packet, std::uint64_t ns, std::uint32_t interface, bool local,
                    Recording& recording);

/// Reads a number from bytes that must contain it, in the given byte order.
template <class Number>
Number number_at(Bytes bytes, std::size_t at, bool big_endian) {
  Number out = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    const auto from = big_endian ? i : sizeof(Number) - 1 - i;
    out = static_cast<Number>(out << 8 | bytes[at + from]);
  }
  return out;
}

/// Cuts the next word off a line; words are separated by blanks and tabs. Empty if there is none.
std::string_view next_word(std::string_view& line);

}  // namespace mlcca::learn
