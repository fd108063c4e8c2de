// SPDX-License-Identifier: BSD-2-Clause
// UTF-8 for strings from the kernel and the command line, which may have any bytes: protobuf
// refuses strings that are not UTF-8.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::control {

/// Whether the text is well-formed by RFC 3629.
bool is_utf8(std::string_view text);

/// A copy of `text` with U+FFFD for each byte that is not part of well-formed UTF-8.
std::string to_utf8(std::string_view text);

}  // namespace mlcca::control
