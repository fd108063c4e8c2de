// SPDX-License-Identifier: BSD-2-Clause
// The bytes of requests and replies. Private to control/.
#pragma once
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "control/messages.hpp"

namespace mlcca::control {

/// Appends the message to `bytes`. Text that is not UTF-8 goes out with U+FFFD for each wrong byte.
void write(const Request& from, std::string& bytes);
void write(const Reply& from, std::string& bytes);
/// All but the id.
void write_without_id(const Reply& from, std::string& bytes);

/// Fields that control.proto does not have are skipped; a value of an enum that it does not have
/// is the default. Error: the bytes are no such message, a text is not UTF-8, or the body is one
/// that we do not know.
Result<Request> read_request(std::string_view bytes);
Result<Reply> read_reply(std::string_view bytes);

}  // namespace mlcca::control
