// SPDX-License-Identifier: BSD-2-Clause
// Counters as lines of JSON, each with what has changed since the one before: for programs that
// follow them, such as the page of Cockpit.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "tools/top/sample.hpp"

namespace mlcca::tools::top {

class Changes {
 public:
  /// One object, and a newline. "deliveries", where these are others than before: what names each.
  /// "counters": of those that have changed, by their places in "deliveries". "interfaces": of
  /// those whose counters have changed, by name.
  [[nodiscard]] std::string line(const Sample& now, std::uint64_t unix_ns);

 private:
  bool is_first_ = true;
  std::vector<control::Channel> before_;                  ///< only what names and counts
  std::map<std::string, control::Interface> interfaces_;  ///< by name, only what counts
};

}  // namespace mlcca::tools::top
