// SPDX-License-Identifier: BSD-2-Clause
// The readers of each format of recordings; see recording.hpp.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {

using Bytes = std::span<const std::uint8_t>;

/// What each reader gets. An error of it has no name of the file yet: "line 7: …".
struct Recording {
  Bytes bytes;
  Interfaces& interfaces;
  const OnFrame& on_frame;
  std::string stem;  ///< of the file's name: what formats without interface names call theirs
  Left left{};
  std::uint64_t handed_over = 0;  ///< frames

  /// Something that is no frame, and is passed over.
  void pass_over(const std::string& what) {
    if (left.lines++ == 0) left.first = what;
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
/// longer than any format has.
class Lines {
 public:
  static constexpr std::size_t kLongest = 4096;
  explicit Lines(Bytes bytes)
      : rest_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {
  }  // NOLINT(*-reinterpret-cast)
  /// False at the end.
  bool next() {
    if (rest_.empty()) return false;
    ++number_;
    const auto end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    return true;
  }
  [[nodiscard]] std::string_view line() const { return line_; }
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::string_view line_;
  std::uint64_t number_ = 0;
};

/// What candump shows on a screen, as the first line tells.
enum class Screen : std::uint8_t { none, with_times, with_dates, without_times };
Screen screen_of(Bytes bytes);
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
