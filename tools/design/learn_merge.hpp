// SPDX-License-Identifier: BSD-2-Clause
// What was learned against what is described already: the difference, as a patch that a person
// reads and applies, and what contradicts the description.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "tools/learn/draft.hpp"

namespace mlcca::tools::design {

/// Networks and the gateway of a described system, by the names of interfaces: for DraftOptions.
/// Interfaces that no port names are left out. `gateway` may be empty where there is one alone.
Result<void> adopt(const core::System& system, const std::string& gateway,
                   learn::DraftOptions& options);

struct Merged {
  /// Each file that would change: its path, and what it would be.
  std::vector<std::pair<std::string, std::string>> files;
  std::vector<std::string> differs;  ///< a line each: what was seen and is not as it is described
};

/// `system` was read of a description; its files must not have changed since. An interface that it
/// does not have is an error: its network would have to be described first.
Result<Merged> merge(const core::System& system, const learn::Draft& draft,
                     const learn::DraftOptions& options);

/// A unified diff, as diff(1) makes it, of a file against what it would be.
Result<std::string> diff_of(const std::string& path, const std::string& text);

}  // namespace mlcca::tools::design
