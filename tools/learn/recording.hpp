// SPDX-License-Identifier: BSD-2-Clause
// Recordings of traffic: logs of candump (-l, -L) and what it shows on a screen (-ta, -tz), pcap
// and pcapng with frames of SocketCAN and of Ethernet, logs of Vector tools in text (ASC) and
// binary (BLF); also packed by gzip, and from a pipe. What they hold is input from outside.
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
  /// The number of a name; kMost where there are that many others. A name that is of the other
  /// medium already, as "any" can be of both, gets "-can" or "-eth" at its end.
  std::uint32_t number_of(std::string_view name, Medium medium = Medium::can);
  /// The same of a name that no recording has, and that was made for it.
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

/// What was in a recording beside frames.
struct Left {
  std::uint64_t lines = 0;       ///< or records that are no frames
  std::string first;             ///< where the first one is and what it is
  std::uint64_t interfaces = 0;  ///< frames of interfaces beyond Interfaces::kMost
};

/// Hands over the frames of a recording in its order. Formats that have numbers of channels instead
/// of names give "can" and the number. An error says what is wrong with the file, with the line or
/// the offset; the frames before it have been handed over. The path "-" is standard input.
Result<Left> read_recording(const std::string& path, Interfaces& interfaces,
                            const OnFrame& on_frame);
/// The same of bytes, and of what comes piece by piece, packed by gzip or not; `stem`: the name of
/// an interface in a format that has none.
Result<Left> read_recording(std::span<const std::uint8_t> bytes, const std::string& stem,
                            Interfaces& interfaces, const OnFrame& on_frame);
Result<Left> read_recording(Input& input, const std::string& stem, Interfaces& interfaces,
                            const OnFrame& on_frame);

}  // namespace mlcca::learn
