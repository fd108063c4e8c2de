// SPDX-License-Identifier: BSD-2-Clause
// The tags that a description states for a bus, for its broker.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "relay/famouso/tag_broker.hpp"

namespace mlcca::relay {

/// Of the channels that have one there, and of SUBSCRIB where its tag is stated. Errors: there is
/// no such network, or it is no bus of FAMOUSO.
[[nodiscard]] Result<std::vector<TagBroker::Dealt>> described_tags(const core::System& system,
                                                                   const std::string& network);

}  // namespace mlcca::relay
