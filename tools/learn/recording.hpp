// SPDX-License-Identifier: BSD-2-Clause
// Reads recordings of traffic, which are untrusted input: logs of candump (-l, -L) and its output
// on a screen (-ta, -tz), pcap and pcapng with frames of SocketCAN and Ethernet, and logs of Vector
// tools in text (ASC) and binary form (BLF); each also compressed by gzip, and from a pipe.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "tools/learn/frame.hpp"
#include "tools/learn/input.hpp"

namespace mlcca::learn {

/// The interfaces of all recordings, numbered in the order in which they were first seen.
class Interfaces {
 public:
  static constexpr std::size_t kMost = 64;
  /// Where the interface of a made-up name comes from.
  struct Origin {
    std::string recording;
    std::string wanted;  ///< the name that it would have had alone, as "can1" of channel 1
  };

  /// Interfaces without names are from now on those of this recording.
  void begin_recording(std::string recording);
  /// No made-up name equals this one, which other sources have.
  void reserve(std::string name) { reserved_.insert(std::move(name)); }
  /// The number of a name; kMost if that many other names exist. "any" can stand for both media; if
  /// the name already has a number for the other medium, it gets "-can" or "-eth" at its end. An
  /// interface with a made-up name that equals this one gets another name.
  std::uint32_t number_of(std::string_view name, Medium medium = Medium::can);
  /// The number of an interface of this recording, which states no name of it. It gets this name,
  /// or a similar one if a source or another recording has an interface with this name.
  std::uint32_t number_of_made_up(std::string_view name, Medium medium = Medium::can);
  [[nodiscard]] const std::map<std::string, Origin>& made_up() const { return made_up_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] const std::vector<Medium>& media() const { return media_; }

 private:
  std::uint32_t add(std::string name, Medium medium);
  [[nodiscard]] bool is_taken(const std::string& name) const;
  [[nodiscard]] std::string distinguished(const std::string& name) const;
  void rename(std::uint32_t number);

  std::vector<std::string> names_;
  std::vector<Medium> media_;
  std::map<std::string, Origin> made_up_;
  std::set<std::string> reserved_;
  std::string recording_;
  /// The interfaces of this recording whose names are made up.
  std::map<std::pair<std::string, Medium>, std::uint32_t> unnamed_;
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

/// In which order recordings are read, so that the made-up names of interfaces do not depend on the
/// order in which they are given: first those with names, and last those without. What a pipe has
/// is not known.
enum class Naming : std::uint8_t { names, unknown, none };
Naming naming_of(const std::string& path);

/// Passes the frames of a recording on in their order. Formats with numbers instead of names give
/// "can" and the number. An error says what is wrong with the file, with the line or offset; the
/// frames before it were passed on. The path "-" is standard input. A pipe ends when `stop` returns
/// true, which is called ten times a second.
Result<Left> read_recording(const std::string& path, Interfaces& interfaces,
                            const OnFrame& on_frame, const std::function<bool()>& stop = {});
/// The same for bytes, and for input that comes piece by piece, compressed by gzip or not. `stem`
/// is the name of the interface in a format that has none.
Result<Left> read_recording(std::span<const std::uint8_t> bytes, const std::string& stem,
                            Interfaces& interfaces, const OnFrame& on_frame);
Result<Left> read_recording(Input& input, const std::string& stem, Interfaces& interfaces,
                            const OnFrame& on_frame);

}  // namespace mlcca::learn
