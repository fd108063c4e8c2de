// SPDX-License-Identifier: BSD-2-Clause
// All files of a description in one text, as gateways hand it to each other: in the order in which
// they are opened, so that inclusions find their files without names.
#pragma once
#include <cstddef>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/sha256.hpp"

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

/// Of a description, by those of its files in the order in which they are opened. Names of files do
/// not count: they differ between machines.
[[nodiscard]] Sha256::Digest digest_of(std::span<const Sha256::Digest> files);
/// As whoever reads the text finds it; nothing: it is no such text.
[[nodiscard]] std::optional<Sha256::Digest> digest_of(std::string_view bundle);

}  // namespace mlcca::description
