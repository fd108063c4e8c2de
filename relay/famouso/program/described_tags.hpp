// SPDX-License-Identifier: BSD-2-Clause
// The tags that a description states for a FAMOUSO bus.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "relay/famouso/tag_broker.hpp"

namespace mlcca::relay {

/// The tags of the channels on this bus, and of SUBSCRIB if the description states one. Fails if
/// there is no such network, or if its profile is not FAMOUSO's.
[[nodiscard]] Result<std::vector<TagBroker::Dealt>> described_tags(const core::System& system,
                                                                   const std::string& network);

}  // namespace mlcca::relay
