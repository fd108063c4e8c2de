// SPDX-License-Identifier: BSD-2-Clause
// Compares what was learned with an existing description. The difference becomes a patch that a
// person reads and applies; contradictions are listed.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "tools/learn/draft.hpp"

namespace mlcca::tools::design {

/// Takes the networks and the gateway of a described system into `options`, by the names of
/// interfaces. Interfaces that no port has are left out. `gateway` may be empty if there is only
/// one.
Result<void> adopt(const core::System& system, const std::string& gateway,
                   learn::DraftOptions& options);

/// The error of an interface that no port of the gateway names.
[[nodiscard]] std::string not_described(const std::string& interface);

/// The result of the comparison.
struct Merged {
  /// The path and new content of each file that would change.
  std::vector<std::pair<std::string, std::string>> files;
  std::vector<std::string> differs;  ///< lines about what was seen and is described differently
  std::vector<std::string> notes;    ///< lines about changes that the files do not have
};

/// Compares a draft with `system`, whose files must not have changed since they were read. An error
/// if the system does not have an interface: its network must be described first.
Result<Merged> merge(const core::System& system, const learn::Draft& draft,
                     const learn::DraftOptions& options);

}  // namespace mlcca::tools::design
