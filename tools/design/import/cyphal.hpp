// SPDX-License-Identifier: BSD-2-Clause
// Imports registers of Cyphal nodes, as `yakut register-batch` prints them: the subjects that a
// node publishes and subscribes on Cyphal/CAN.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

Result<ImportedNetwork> import_cyphal(std::string_view text, const std::string& file,
                                      const ImportOptions& options);

/// The largest size in bytes of a message of a type with version, such as
/// "uavcan.node.Heartbeat.1.0"; nullopt if the type is not known here.
std::optional<Value> cyphal_size(std::string_view type);

}  // namespace mlcca::tools::design
