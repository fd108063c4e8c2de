// SPDX-License-Identifier: BSD-2-Clause
// Texts of files that do not say how they are encoded.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// The text without a byte order mark. What is no UTF-8 is read as Windows-1252, which has every
/// character of Latin-1; `converted` says whether.
std::string utf8_of(std::string_view text, bool& converted);

/// "drive" of "dir/drive.yaml".
std::string stem_of_file(std::string_view path);

/// Neither blanks nor control characters at the ends.
std::string_view without_blanks(std::string_view text);

}  // namespace mlcca::tools::design
