// SPDX-License-Identifier: BSD-2-Clause
// All files of a description in one text, as gateways hand it to each other: in the order in which
// they are opened, so that inclusions find their files without names.
#pragma once
#include <cstddef>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::description {

/// Bytes of all of it. What is longer is not handed on.
inline constexpr std::size_t kMaxBundle = std::size_t{8} << 20U;

struct BundledFile {
  std::string name;  ///< for problems alone
  std::string content;
};

/// Empty where it is longer than it may be.
[[nodiscard]] std::string bundle_of(const std::vector<BundledFile>& files);
/// At least one, with parts of the text. The error says that it is no such text.
struct FileInBundle {
  std::string_view name, content;
};
[[nodiscard]] std::expected<std::vector<FileInBundle>, std::string> files_in(
    std::string_view bundle);

}  // namespace mlcca::description
