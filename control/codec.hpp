// SPDX-License-Identifier: BSD-2-Clause
// Messages to bytes and back: each one a varint length and a protobuf message, as the delimited
// form of every protobuf runtime has it.
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

/// Text that is not UTF-8 (an interface alias may be anything) goes out with U+FFFD for each wrong
/// byte. The size is the caller's to check: the other side refuses more than Request::kMaxBytes
/// bytes behind the length.
std::string encode(const Request& request);

/// As above. A reply that would be larger than Reply::kMaxBytes becomes an Error that says so.
std::string encode(const Reply& reply);

/// A reply that has no id yet, without its length, to be sent by whoever knows the id: see
/// with_id(). A reply that would be larger than `most` becomes an Error that says so.
std::string encode_body(const Reply& reply, std::size_t most = Reply::kMaxBytes);
/// What encode() gives of the reply that `body` is of, with this id.
std::string with_id(std::uint64_t id, std::string_view body);

/// Takes one whole request off the buffer; nullopt while it is incomplete. After an error (too
/// large, malformed, unknown request) nothing more can be read from the stream: answer with the
/// text, id 0, ErrorKind::invalid, and close it.
Result<std::optional<Request>> decode_request(Buffer& buffer);

/// Takes one whole reply off the buffer; nullopt while it is incomplete. After an error the stream
/// cannot be read any further.
Result<std::optional<Reply>> decode_reply(Buffer& buffer);

}  // namespace mlcca::control
