// SPDX-License-Identifier: BSD-2-Clause
// Paths of files as URI references (RFC 3986), for readers that follow links.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// A path as a reader of SARIF or HTML wants it.
struct FileUri {
  std::string text;       ///< percent-encoded, without dot segments
  bool relative = false;  ///< to the folder in which the check runs; otherwise file:///…
};

/// Relative where the path is relative and stays below the working directory. `folder` is that
/// directory, absolute: a path that leaves it becomes absolute.
FileUri file_uri(std::string_view path, std::string_view folder);

/// The same for the working directory of this process.
FileUri file_uri(std::string_view path);

}  // namespace mlcca::tools::design
