// SPDX-License-Identifier: BSD-2-Clause
// Notices that frames are being dropped, and says so without flooding the journal.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace mlcca {

/// "3 frames dropped …"; in audit mode, where nothing is, "would be dropped: 3 frames …".
[[nodiscard]] std::string dropped_line(bool audit, std::uint64_t frames, const std::string& which);

/// Remembers counters by name. Times are in seconds of any steady clock.
class DropWatch {
 public:
  /// A subject that goes on being dropped is mentioned again after this time.
  static constexpr std::int64_t kRepeat = 60;

  /// Frames dropped since the last mention, if they are to be mentioned now. The first look at a
  /// counter only remembers it: what a former daemon saw is not news.
  std::optional<std::uint64_t> look(const std::string& name, std::uint64_t dropped,
                                    std::int64_t now);

  /// What was not mentioned yet is at the next look, however short ago the last mention was.
  void wake();

  /// After a reload the names may mean something else.
  void forget() { seen_.clear(); }

 private:
  struct Seen {
    std::uint64_t mentioned = 0;
    std::int64_t at = 0;
    bool ever = false;
  };
  std::map<std::string, Seen> seen_;
};

}  // namespace mlcca
