// SPDX-License-Identifier: BSD-2-Clause
// The attributes of xi:include, and the file that they refer to.
#pragma once
#include <cstddef>
#include <expected>
#include <string>
#include <string_view>

namespace mlcca::description {

/// Longest href in bytes: the longest path of the system, each byte percent-encoded.
inline constexpr std::size_t kMaxHref = std::size_t{3} * 4096;

/// The text for an attribute other than href; empty if it is allowed.
std::string explain_include_key(std::string_view key, std::string_view value);

/// The path of the local file that `href` refers to: percent-decoded and, if relative, below
/// `folder` (empty: the working directory). Fails with the reason for a scheme, host, query or
/// fragment, an empty name, or an incomplete percent-encoding.
std::expected<std::string, std::string> included_path(std::string_view href,
                                                      std::string_view folder);

/// The folder to which the hrefs of a file are relative: its path up to and including the last
/// slash.
std::string_view folder_of(std::string_view path);

}  // namespace mlcca::description
