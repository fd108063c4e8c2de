// SPDX-License-Identifier: BSD-2-Clause
// The channels of a draft for people and for programs.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "tools/learn/draft.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

/// A table with a line for each channel.
[[nodiscard]] std::string table_of(const learn::Draft& draft, Color color);

/// An array with an object for each channel. Times are in ns.
[[nodiscard]] nlohmann::ordered_json channels_of(const learn::Draft& draft);

}  // namespace mlcca::tools::design
