// SPDX-License-Identifier: BSD-2-Clause
// Which interfaces an operator has named to be closed before there is any decision: in gate.conf
// and in the files *.conf of conf.d beside it.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca {

struct NamedInterface {
  std::string name;
  std::string place;  ///< file:line
};

struct InterfaceFiles {
  /// What one file names no other one takes away; each name once, where it was named first.
  std::vector<NamedInterface> named;
  /// As file:line: reason. With one of them it is not known which others are meant.
  std::vector<std::string> mistakes;

  [[nodiscard]] bool names(std::string_view interface) const;
};

inline constexpr std::size_t kInterfaceFileBytes = std::size_t{1} << 16U;
inline constexpr std::size_t kInterfaceFiles = 256;
inline constexpr std::size_t kNamedInterfaces = 1024;

/// gate.conf of the directory, then conf.d/*.conf in the order of their names. What is not there
/// names nothing.
[[nodiscard]] InterfaceFiles read_interface_files(const std::string& directory);

}  // namespace mlcca
