// SPDX-License-Identifier: BSD-2-Clause
// What a description that is there means for what is learned: its profiles rule, and a patch of it
// is checked before it is proposed.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/model/system.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::tools::design {

/// The profiles of the described networks by interface, without networks that have none. `networks`
/// are the names of networks, by interface.
[[nodiscard]] std::map<std::string, core::Profile> described_profiles(
    const core::System& system, const std::map<std::string, std::string>& networks);

/// Removes from the draft the channels that no described network of their interfaces can have,
/// because it has another profile or is on another medium. Returns a note for each such network.
[[nodiscard]] std::vector<std::string> leave_out_others(
    const core::System& system, const learn::Observer& observer,
    const std::vector<std::string>& names, const std::map<std::string, std::string>& networks,
    learn::Draft& draft);

/// Notes on the errors that a check finds in the patched description and not in `system`. `files`
/// are the paths and new contents of the files that change.
[[nodiscard]] std::vector<std::string> refused_when_patched(
    core::System system, const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace mlcca::tools::design
