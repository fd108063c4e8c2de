// SPDX-License-Identifier: BSD-2-Clause
// The body of control messages as bytes, without the length. Used only within control/.
#pragma once
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "control/messages.hpp"

namespace mlcca::control {

/// Appends the encoded message to `bytes`. In text that is not UTF-8 each wrong byte becomes
/// U+FFFD.
void write(const Request& from, std::string& bytes);
void write(const Reply& from, std::string& bytes);
/// Appends the encoded message without its id.
void write_without_id(const Reply& from, std::string& bytes);

/// Decodes a message. Unknown fields are skipped, and an unknown value of an enumeration becomes
/// its default. An error if the bytes are malformed, a text is not UTF-8, or the body is unknown.
Result<Request> read_request(std::string_view bytes);
Result<Reply> read_reply(std::string_view bytes);

}  // namespace mlcca::control
