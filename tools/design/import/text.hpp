// SPDX-License-Identifier: BSD-2-Clause
// Text of files that do not state their encoding.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// The text in UTF-8 without a byte order mark. Text that is not UTF-8 is taken as Windows-1252,
/// which contains every printable character of Latin-1, and `converted` is set.
std::string utf8_of(std::string_view text, bool& converted);

/// The file name without folder and extension: "drive" of "dir/drive.yaml".
std::string stem_of_file(std::string_view path);

/// The text without blanks and control characters at both ends.
std::string_view without_blanks(std::string_view text);

}  // namespace mlcca::tools::design
