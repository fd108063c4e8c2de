// SPDX-License-Identifier: BSD-2-Clause
// Encoding of control messages: a varint length, then a protobuf message, which is the delimited
// format of the protobuf libraries.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"

namespace mlcca::control {

/// Encodes a request with its length. In text that is not UTF-8 (an interface alias may be
/// anything) each wrong byte becomes U+FFFD. The caller checks the size: the daemon refuses
/// messages of more than Request::kMaxBytes bytes.
std::string encode(const Request& request);

/// Encodes a reply with its length. A reply that would exceed Reply::kMaxBytes becomes an Error
/// that says so.
std::string encode(const Reply& reply);

/// Encodes a reply without its length and id, so that it can be encoded once and sent with several
/// ids; see with_id(). A reply that would exceed `most` becomes an Error that says so.
std::string encode_body(const Reply& reply, std::size_t most = Reply::kMaxBytes);
/// Completes the result of encode_body() with an id and the length.
std::string with_id(std::uint64_t id, std::string_view body);

/// Removes one complete request from the buffer; nullopt while it is incomplete. After an error
/// (too large, malformed, unknown request) the stream cannot be read further: answer with the error
/// text, id 0 and ErrorKind::invalid, and close it.
Result<std::optional<Request>> decode_request(Buffer& buffer);

/// Removes one complete reply from the buffer; nullopt while it is incomplete. After an error the
/// stream cannot be read further.
Result<std::optional<Reply>> decode_reply(Buffer& buffer);

}  // namespace mlcca::control
