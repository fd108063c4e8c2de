// SPDX-License-Identifier: BSD-2-Clause
// The interfaces that an operator has named for closing before any decision: in gate.conf and the
// files conf.d/*.conf beside it.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca {

/// One name in one of the files.
struct NamedInterface {
  std::string name;
  std::string place;  ///< file:line of the name
};

/// The result of reading these files.
struct InterfaceFiles {
  /// All names of all files, each once, where it occurs first.
  std::vector<NamedInterface> named;
  /// As "file:line: reason". If there is a mistake, it is not known which other interfaces are
  /// meant.
  std::vector<std::string> mistakes;

  [[nodiscard]] bool names(std::string_view interface) const;
};

inline constexpr std::size_t kInterfaceFileBytes = std::size_t{1} << 16U;
inline constexpr std::size_t kInterfaceFiles = 256;
inline constexpr std::size_t kNamedInterfaces = 1024;

/// Reads gate.conf of the directory, then conf.d/*.conf in the order of their names. A missing file
/// names nothing.
[[nodiscard]] InterfaceFiles read_interface_files(const std::string& directory);

}  // namespace mlcca
