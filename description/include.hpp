// SPDX-License-Identifier: BSD-2-Clause
// The attributes of xi:include: which file is meant.
#pragma once
#include <cstddef>
#include <expected>
#include <string>
#include <string_view>

namespace mlcca::description {

/// Bytes of an href; as long as the system's longest path, each byte percent-encoded.
inline constexpr std::size_t kMaxHref = std::size_t{3} * 4096;

/// What is wrong with an attribute other than href, or an empty text.
std::string explain_include_key(std::string_view key, std::string_view value);

/// The path of the local file that `href` refers to: percent-decoded, and if it is relative,
/// below `folder` (an empty one is the working directory). The error says what would be right: no
/// scheme, host, query or fragment, no empty name, no incomplete percent-encoding.
std::expected<std::string, std::string> included_path(std::string_view href,
                                                      std::string_view folder);

/// The folder that a file's relative hrefs start from: its path up to the last slash, which is
/// kept.
std::string_view folder_of(std::string_view path);

}  // namespace mlcca::description
