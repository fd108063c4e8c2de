// SPDX-License-Identifier: BSD-2-Clause
// Converts file paths into URI references (RFC 3986) for SARIF and HTML.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// A file as URI reference.
struct FileUri {
  std::string text;       ///< percent-encoded, without dot segments
  bool relative = false;  ///< relative to the working directory of the check; otherwise it is
                          ///< file:///…
};

/// The reference to `path`. `folder` is the absolute working directory; a relative path that stays
/// below it gives a relative reference, any other path an absolute one.
FileUri file_uri(std::string_view path, std::string_view folder);

/// The same for the working directory of this process.
FileUri file_uri(std::string_view path);

}  // namespace mlcca::tools::design
