// SPDX-License-Identifier: BSD-2-Clause
// Imports CANopen device descriptions (CiA 306): an EDS for a type of device, a DCF for one device.
// The PDOs and the heart-beat of a node become messages.
#pragma once
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

Result<ImportedNetwork> import_eds(std::string_view text, const std::string& file,
                                   const ImportOptions& options);

}  // namespace mlcca::tools::design
