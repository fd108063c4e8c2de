// SPDX-License-Identifier: BSD-2-Clause
// Protobuf refuses strings that are not UTF-8, but the kernel and the command line do not promise
// it.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::control {

/// Well-formed by RFC 3629.
bool is_utf8(std::string_view text);

/// `text` with U+FFFD for each byte that is not part of well-formed UTF-8.
std::string to_utf8(std::string_view text);

}  // namespace mlcca::control
