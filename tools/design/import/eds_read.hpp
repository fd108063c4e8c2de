// SPDX-License-Identifier: BSD-2-Clause
// The sections of an EDS or DCF, which is an INI file.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.hpp"

namespace mlcca::tools::design {

struct EdsEntry {
  int line = 0;
  std::string value;  ///< ParameterValue, else DefaultValue; perhaps with $NODEID
};

struct EdsFile {
  /// By index and sub-index.
  std::map<std::pair<std::uint32_t, std::uint32_t>, EdsEntry> objects;
  std::string product;  ///< of [DeviceInfo]
  std::string node_name;
  std::optional<unsigned> node;      ///< of [DeviceComissioning]
  std::optional<unsigned> kilobits;  ///< bit rate, the same

  /// The number there, with $NODEID as `node`; none: it is not stated, or is no number.
  [[nodiscard]] std::optional<std::uint32_t> number(std::uint32_t index, std::uint32_t sub,
                                                    unsigned of_node) const;
};

/// `file` is its name in errors.
Result<EdsFile> read_eds(std::string_view text, const std::string& file);

}  // namespace mlcca::tools::design
