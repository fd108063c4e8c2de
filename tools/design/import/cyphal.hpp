// SPDX-License-Identifier: BSD-2-Clause
// Registers of Cyphal nodes, as `yakut register-batch` prints them: which subjects a node publishes
// and subscribes on Cyphal/CAN.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

Result<ImportedNetwork> import_cyphal(std::string_view text, const std::string& file,
                                      const ImportOptions& options);

/// Most bytes of a message of that type and version, such as "uavcan.node.Heartbeat.1.0"; none: it
/// is not known here.
std::optional<Value> cyphal_size(std::string_view type);

}  // namespace mlcca::tools::design
