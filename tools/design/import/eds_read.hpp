// SPDX-License-Identifier: BSD-2-Clause
// Parses an EDS or DCF, which is an INI file.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// The value of an object.
struct EdsEntry {
  int line = 0;
  std::string value;  ///< ParameterValue, or else DefaultValue; can contain $NODEID
};

/// The content of a file.
struct EdsFile {
  /// The objects by index and sub-index.
  std::map<std::pair<std::uint32_t, std::uint32_t>, EdsEntry> objects;
  std::string product;  ///< from [DeviceInfo]
  std::string node_name;
  std::optional<unsigned> node;      ///< from [DeviceComissioning] (spelled so in CiA 306)
  std::optional<unsigned> kilobits;  ///< bit rate in kbit/s, from the same section

  /// The number at an index, with $NODEID replaced by `of_node`; nullopt if none is stated or it is
  /// no number.
  [[nodiscard]] std::optional<std::uint32_t> number(std::uint32_t index, std::uint32_t sub,
                                                    unsigned of_node) const;
};

/// Parses the text; `file` is its name in errors.
Result<EdsFile> read_eds(std::string_view text, const std::string& file);

}  // namespace mlcca::tools::design
