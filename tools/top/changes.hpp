// SPDX-License-Identifier: BSD-2-Clause
// Counters as lines of JSON, each with the changes since the line before, for programs that follow
// them such as the Cockpit page.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "tools/top/sample.hpp"

namespace mlcca::tools::top {

/// Remembers the last sample.
class Changes {
 public:
  /// The next line, one object. "deliveries": the names of each delivery, if they differ from
  /// before. "counters": the counters that have changed, by position in "deliveries". "interfaces":
  /// those whose counters have changed, by name.
  [[nodiscard]] std::string line(const Sample& now, std::uint64_t unix_ns);

 private:
  bool is_first_ = true;
  std::vector<control::Channel> before_;                  ///< only what identifies and counts
  std::map<std::string, control::Interface> interfaces_;  ///< by name, only counters
};

}  // namespace mlcca::tools::top
