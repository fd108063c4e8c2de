// SPDX-License-Identifier: BSD-2-Clause
// Bundles: all files of a description in one text, by which gateways pass it on. The files are in
// the order in which they are opened, so inclusions find them without names.
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

/// Largest bundle in bytes. A longer description is not passed on.
inline constexpr std::size_t kMaxBundle = std::size_t{8} << 20U;

/// A file that is put into a bundle.
struct BundledFile {
  std::string name;  ///< only for problem reports
  std::string content;
};

/// The bundle of the files; empty if it would exceed kMaxBundle.
[[nodiscard]] std::string bundle_of(const std::vector<BundledFile>& files);
/// A file in a bundle; refers to the bundle's text. files_in() returns at least one, or an error if
/// the text is no bundle.
struct FileInBundle {
  std::string_view name, content;
};
[[nodiscard]] std::expected<std::vector<FileInBundle>, std::string> files_in(
    std::string_view bundle);

/// The digest of a description, from the digests of its files in the order in which they are
/// opened. File names are not included, because they differ between machines.
[[nodiscard]] Sha256::Digest digest_of(std::span<const Sha256::Digest> files);
/// The digest of the description in a bundle; nullopt if the text is no bundle.
[[nodiscard]] std::optional<Sha256::Digest> digest_of(std::string_view bundle);

}  // namespace mlcca::description
