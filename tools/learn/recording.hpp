// SPDX-License-Identifier: BSD-2-Clause
// Reads recordings of traffic, which are untrusted input: logs of candump (-l, -L) and its output
// on a screen (-ta, -tz), pcap and pcapng with frames of SocketCAN and Ethernet, and logs of Vector
// tools in text (ASC) and binary form (BLF); each also compressed by gzip, and from a pipe.
#pragma once
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/learn/frame.hpp"
#include "tools/learn/input.hpp"

namespace mlcca::learn {

/// The interfaces of all recordings, numbered in the order in which they were first seen.
class Interfaces {
 public:
  static constexpr std::size_t kMost = 64;
  /// The number of a name; kMost if that many other names exist. "any" can stand for both media; if
  /// the name already has a number for the other medium, it gets "-can" or "-eth" at its end.
  std::uint32_t number_of(std::string_view name, Medium medium = Medium::can);
  /// The same for a generated name that no recording has.
  std::uint32_t number_of_made_up(std::string_view name, Medium medium = Medium::can);
  [[nodiscard]] const std::set<std::string>& made_up() const { return made_up_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] const std::vector<Medium>& media() const { return media_; }

 private:
  std::vector<std::string> names_;
  std::vector<Medium> media_;
  std::set<std::string> made_up_;
};

using OnFrame = std::function<void(const Frame&)>;

/// What a recording has in addition to frames.
struct Left {
  std::uint64_t lines = 0;       ///< number of lines or records that are not frames
  std::string first;             ///< where the first of them is, and what it is
  std::uint64_t errors = 0;      ///< number of error frames: what a controller says of its bus
  std::string cut;               ///< where the file ends early; empty if it is complete
  std::uint64_t interfaces = 0;  ///< number of frames of interfaces beyond Interfaces::kMost
};

/// Passes the frames of a recording on in their order. Formats with numbers instead of names give
/// "can" and the number. An error says what is wrong with the file, with the line or offset; the
/// frames before it were passed on. The path "-" is standard input.
Result<Left> read_recording(const std::string& path, Interfaces& interfaces,
                            const OnFrame& on_frame);
/// The same for bytes, and for input that comes piece by piece, compressed by gzip or not. `stem`
/// is the name of the interface in a format that has none.
Result<Left> read_recording(std::span<const std::uint8_t> bytes, const std::string& stem,
                            Interfaces& interfaces, const OnFrame& on_frame);
Result<Left> read_recording(Input& input, const std::string& stem, Interfaces& interfaces,
                            const OnFrame& on_frame);

}  // namespace mlcca::learn
